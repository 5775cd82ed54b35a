// Packets through instances: the rays that have come to one make packets in its space. The guard lets the header through once
// for each target that Highway compiles.
#if defined(ACCEL_INSTANCE_PACKETS_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_INSTANCE_PACKETS_SIMD_INL_H
#undef ACCEL_INSTANCE_PACKETS_SIMD_INL_H
#else
#define ACCEL_INSTANCE_PACKETS_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <span>
#include <type_traits>

#include "libaccel/packet/frustum.h"
#include "libaccel/packet/packet_flight_simd-inl.h"
#include "libaccel/structure/two_level_bvh8.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE const char* place_of(const TwoLevelBvh8View& view, NodeRef ref) {
  return is_instance(ref) ? reinterpret_cast<const char*>(view.instances + instance_number(ref)) : place_of(view.top(), ref);
}

// Leaves of instances. What a packet's rays hit in one is what they hit by themselves (trace/two_level.h): the search there
// begins with no hit, in the interval that is left.
template <Query kQuery>
class Leaves<kQuery, TwoLevelBvh8View> {
 public:
  Leaves() { std::iota(ids_, ids_ + kMaxPacketSize, 0u); }

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
  static constexpr std::uint32_t kFaces = kNoFace + 1;
  // Of fewer rays, packets cost more than they save.
  static constexpr std::uint32_t kFewest = 8;

  HWY_NOINLINE std::uint32_t intersect_instance(const Bvh8View& tree, const Bvh8Instance& instance, Flight& f) {
    std::uint32_t firsts[kFaces + 1];
    take_rays(instance, f, firsts);
    std::uint32_t answered = 0;
    for (std::uint32_t face = 0; face < kFaces; ++face) {
      const std::uint32_t first = firsts[face], end = firsts[face + 1];
      if (first == end) continue;
      if (face == kNoFace || end - first < kFewest || is_leaf(tree.root))
        answered += trace_by_turns(tree, instance, first, end, f.packet);
      else
        answered += trace_packet(tree, instance, face, first, end, f);
    }
    return answered;
  }

  // The active rays, in the instance's space and sorted by face.
  HWY_INLINE void take_rays(const Bvh8Instance& instance, const Flight& f, std::uint32_t firsts[kFaces + 1]) {
    Ray rays[kMaxPacketSize];
    std::uint32_t lanes[kMaxPacketSize], counts[kFaces] = {}, count = 0;
    std::uint8_t faces[kMaxPacketSize];
    const Packet& p = f.packet;
    for (GroupBits rest = f.active.groups; rest != 0; rest &= rest - 1) {
      const std::uint32_t g = first_of(rest);
      std::uint32_t active = 0;
      std::memcpy(&active, f.active.rays[g], (width() + 7) / 8);
      for (; active != 0; active &= active - 1) {
        const std::uint32_t lane = g * width() + static_cast<std::uint32_t>(std::countr_zero(active));
        if (!(p.t[lane] >= 0)) continue;  // answered meanwhile
        rays[count] = instance.to_object.ray(p.ray(lane));
        rays[count].t_max = p.t[lane];
        const std::uint32_t face = face_of(rays[count]);
        lanes[count] = lane, faces[count] = static_cast<std::uint8_t>(face);
        ++counts[face], ++count;
      }
    }
    firsts[0] = 0;
    for (std::uint32_t face = 0; face < kFaces; ++face) firsts[face + 1] = firsts[face] + counts[face];
    std::uint32_t next[kFaces];
    std::copy(firsts, firsts + kFaces, next);
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t place = next[faces[i]]++;
      rays_[place] = rays[i], lanes_[place] = lanes[i];
    }
  }

  HWY_INLINE std::uint32_t trace_by_turns(const Bvh8View& tree, const Bvh8Instance& instance, std::uint32_t first,
                                          std::uint32_t end, Packet& p) {
    Answer answers[kMaxPacketSize];
    trace_bvh8_simd<Bvh8Node, PaddedSlabs, Watertight>(tree, std::span<const Ray>(rays_ + first, end - first),
                                                       std::span<Answer>(answers, end - first));
    std::uint32_t answered = 0;
    for (std::uint32_t i = first; i < end; ++i) {
      Hit found;
      if constexpr (kQuery == Query::closest)
        found = answers[i - first];
      else
        found.prim_id = answers[i - first] != 0 ? 0 : kNoHit;
      answered += accept(found, instance, lanes_[i], p);
    }
    return answered;
  }

  HWY_INLINE std::uint32_t trace_packet(const Bvh8View& tree, const Bvh8Instance& instance, std::uint32_t face,
                                        std::uint32_t first, std::uint32_t end, Flight& f) {
    Packet& inside = flight_.packet;
    const Aabb bounds = bounds_of_children(tree.nodes[tree.root]);
    load_rays(rays_ + first, ids_, end - first, static_cast<int>(face >> 1), inside);
    if constexpr (kQuery == Query::any) inside.reach = reach_of(inside, bounds);
    flight_.answered = 0;
    begin(flight_, tree.root, face, bounds, f.way.reversal != 0);
    while (go_on(tree, flight_, leaves_inside_)) {
    }
    std::uint32_t answered = 0;
    for (std::uint32_t i = 0; i < inside.size; ++i)
      answered += accept({inside.t[i], inside.u[i], inside.v[i], inside.prim_id[i]}, instance, lanes_[first + i], f.packet);
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

  std::uint32_t ids_[kMaxPacketSize];    // 0, 1, ...
  Ray rays_[kMaxPacketSize];             // in the instance's space
  std::uint32_t lanes_[kMaxPacketSize];  // where they are in the packet outside
  Flight flight_;
  Leaves<kQuery, Bvh8View> leaves_inside_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
