// Packets through instances: the rays that have come to one make packets in its space. The guard lets the header through once
// for each target that Highway compiles.
#if defined(ACCEL_INSTANCE_PACKETS_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_INSTANCE_PACKETS_SIMD_INL_H
#undef ACCEL_INSTANCE_PACKETS_SIMD_INL_H
#else
#define ACCEL_INSTANCE_PACKETS_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>
#include <span>
#include <type_traits>

#include "libaccel/packet/frustum.h"
#include "libaccel/packet/packet_flight_simd-inl.h"
#include "libaccel/structure/two_level_bvh8.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// Rays as columns, with the lanes where they are in the packet outside, and their faces.
struct alignas(64) RayColumns {
  static constexpr std::uint32_t kMost = kMaxPacketSize + 16;  // and room for a whole vector behind the last

  float org[3][kMost], dir[3][kMost], t_min[kMost], t_max[kMost];
  std::uint32_t lane[kMost], face[kMost];
  std::uint32_t count;

  HWY_INLINE void append(const RayLanes& r, Words lanes, Words faces, Mask keep) {
    const auto add = [&](Floats values, float* to) HWY_ATTR { hn::StoreU(hn::Compress(values, keep), kFloats, to + count); };
    for (int a = 0; a < 3; ++a) add(r.org[a], org[a]), add(r.dir[a], dir[a]);
    add(r.t_min, t_min), add(r.t_max, t_max);
    const auto keep_words = hn::RebindMask(kWords, keep);
    hn::StoreU(hn::Compress(lanes, keep_words), kWords, lane + count);
    hn::StoreU(hn::Compress(faces, keep_words), kWords, face + count);
    count += static_cast<std::uint32_t>(hn::CountTrue(kFloats, keep));
  }

  // From ray i on, where a vector begins; behind the last, the last again.
  HWY_INLINE RayLanes lanes_at(std::uint32_t i) const {
    const std::uint32_t left = count - i;
    const auto column = [&](const float* from) HWY_ATTR {
      const Floats values = load(from + i);
      return HWY_LIKELY(left >= width()) ? values : hn::IfThenElse(hn::FirstN(kFloats, left), values, set(from[count - 1]));
    };
    return {{column(org[0]), column(org[1]), column(org[2])},
            column(t_min),
            {column(dir[0]), column(dir[1]), column(dir[2])},
            column(t_max)};
  }
  HWY_INLINE Mask of_face(std::uint32_t i, std::uint32_t which) const {
    const auto is_it = hn::Eq(hn::Load(kWords, face + i), hn::Set(kWords, which));
    return hn::And(hn::RebindMask(kFloats, is_it), hn::FirstN(kFloats, count - i));
  }
  HWY_INLINE Ray ray(std::uint32_t i) const {
    return {{org[0][i], org[1][i], org[2][i]}, t_min[i], {dir[0][i], dir[1][i], dir[2][i]}, t_max[i]};
  }
};

// AffineInverse::ray(), of the rays from lane i on; of each the interval that is left.
HWY_INLINE RayLanes taken_through(const AffineInverse& map, const Packet& p, std::uint32_t i) {
  Floats from[3], along[3];
  for (int a = 0; a < 3; ++a) from[a] = hn::Sub(load(p.org[a] + i), set(map.origin[a])), along[a] = load(p.dir[a] + i);
  const auto row = [&](int a, const Floats* v) HWY_ATTR {
    const auto product = [&](int b) HWY_ATTR { return hn::Mul(set(map.linear[a][b]), v[b]); };
    return hn::Add(hn::Add(product(0), product(1)), product(2));
  };
  return {{row(0, from), row(1, from), row(2, from)},
          load(p.t_min + i),
          {row(0, along), row(1, along), row(2, along)},
          load(p.t + i)};
}

// Leaves of instances. What a packet's rays hit in one is what they hit by themselves (trace/two_level.h): the search there
// begins with no hit, in the interval that is left.
template <Query kQuery>
class Leaves<kQuery, TwoLevelBvh8View> {
 public:
  template <Share>
  HWY_INLINE std::uint32_t intersect(const TwoLevelBvh8View& view, Flight& f) {
    std::uint32_t answered = 0;
    const Bvh8Instance* instance = view.instances + instance_number(f.ref);
    do answered += intersect_instance(view.tree_of(*instance), *instance, f);
    while ((instance++)->ends_leaf == 0);
    return answered;
  }
  // There is none.
  HWY_INLINE std::uint32_t ask_occluder(const TwoLevelBvh8View&, Packet&) { return 0; }

 private:
  using Answer = std::conditional_t<kQuery == Query::closest, Hit, std::uint8_t>;
  // Of fewer rays, packets cost more than they save.
  static constexpr std::uint32_t kFewest = 8;

  HWY_NOINLINE std::uint32_t intersect_instance(const Bvh8View& tree, const Bvh8Instance& instance, Flight& f) {
    take_rays(instance, f);
    std::uint32_t of_face[kNoFace + 1] = {}, answered = 0;
    for (std::uint32_t i = 0; i < rays_.count; ++i) ++of_face[rays_.face[i]];
    for (std::uint32_t face = 0; face <= kNoFace; ++face) {
      if (of_face[face] == 0) continue;
      const RayColumns& rays = of_face[face] == rays_.count ? rays_ : chosen(face);
      if (face == kNoFace || rays.count < kFewest || is_leaf(tree.root))
        answered += trace_by_turns(tree, instance, rays, f.packet);
      else
        answered += trace_packet(tree, instance, rays, face, f);
    }
    return answered;
  }

  // The active rays, in the instance's space.
  HWY_INLINE void take_rays(const Bvh8Instance& instance, const Flight& f) {
    const Packet& p = f.packet;
    rays_.count = 0;
    for (GroupBits rest = f.active.groups; rest != 0; rest &= rest - 1) {
      const std::uint32_t g = first_of(rest), i = g * width();
      const Mask waiting = hn::Ge(load(p.t + i), set(0));  // others have been answered meanwhile
      const Mask keep = hn::And(hn::LoadMaskBits(kFloats, f.active.rays[g]), waiting);
      const RayLanes r = taken_through(instance.to_object, p, i);
      rays_.append(r, hn::Iota(kWords, i), faces_of(r), keep);
    }
  }

  HWY_INLINE const RayColumns& chosen(std::uint32_t face) {
    chosen_.count = 0;
    for (std::uint32_t i = 0; i < rays_.count; i += width())
      chosen_.append(rays_.lanes_at(i), hn::Load(kWords, rays_.lane + i), hn::Load(kWords, rays_.face + i),
                     rays_.of_face(i, face));
    return chosen_;
  }

  HWY_INLINE std::uint32_t trace_by_turns(const Bvh8View& tree, const Bvh8Instance& instance, const RayColumns& rays,
                                          Packet& p) {
    for (std::uint32_t i = 0; i < rays.count; ++i) by_turns_[i] = rays.ray(i);
    trace_bvh8_simd<Bvh8Node, PaddedSlabs, Watertight>(tree, std::span<const Ray>(by_turns_, rays.count),
                                                       std::span<Answer>(answers_, rays.count));
    std::uint32_t answered = 0;
    for (std::uint32_t i = 0; i < rays.count; ++i) {
      Hit found;
      if constexpr (kQuery == Query::closest)
        found = answers_[i];
      else
        found.prim_id = answers_[i] != 0 ? 0 : kNoHit;
      answered += accept(found, instance, rays.lane[i], p);
    }
    return answered;
  }

  HWY_INLINE std::uint32_t trace_packet(const Bvh8View& tree, const Bvh8Instance& instance, const RayColumns& rays,
                                        std::uint32_t face, Flight& f) {
    Packet& inside = flight_.packet;
    const Aabb bounds = bounds_of_children(tree.nodes[tree.root]);
    fill_packet(rays.count, static_cast<int>(face >> 1), inside, [&](std::uint32_t i) HWY_ATTR { return rays.lanes_at(i); });
    if constexpr (kQuery == Query::any) inside.reach = reach_of(inside, bounds);
    flight_.answered = 0;
    begin(flight_, tree.root, face, bounds, f.way.reversal != 0);
    while (go_on(tree, flight_, leaves_inside_)) {
    }
    std::uint32_t answered = 0;
    for (std::uint32_t i = 0; i < inside.size; ++i)
      answered += accept({inside.t[i], inside.u[i], inside.v[i], inside.prim_id[i]}, instance, rays.lane[i], f.packet);
    return answered;
  }

  // Returns 1 for a new answer.
  static HWY_INLINE std::uint32_t accept(Hit found, const Bvh8Instance& instance, std::uint32_t lane, Packet& p) {
    if (!found.valid()) return 0;
    found.prim_id += instance.first_prim;
    if constexpr (kQuery == Query::any) {
      p.t[lane] = -kInfinity, p.prim_id[lane] = found.prim_id;
      return 1;
    }
    Hit hit{p.t[lane], p.u[lane], p.v[lane], p.prim_id[lane]};
    if (!accept_hit(found, found.t, hit)) return 0;
    p.t[lane] = hit.t, p.u[lane] = hit.u, p.v[lane] = hit.v, p.prim_id[lane] = hit.prim_id;
    return 1;
  }

  RayColumns rays_, chosen_;  // in the instance's space: all, and those of one face
  Ray by_turns_[kMaxPacketSize];
  Answer answers_[kMaxPacketSize];
  Flight flight_;  // inside
  Leaves<kQuery, Bvh8View> leaves_inside_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
