#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/packet/bvh8_packets_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstdint>

#include "libaccel/packet/bvh8_packets_simd.h"
#include "libaccel/packet/frustum_boxes_simd-inl.h"
#include "libaccel/packet/frustum_simd-inl.h"
#include "libaccel/packet/packet_simd-inl.h"
#include "libaccel/packet/watertight_simd-inl.h"
#include "libaccel/trace/bvh8_ray.h"
#include "libaccel/trace/bvh8_simd.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// Groups of a packet are the bits of a word.
using GroupBits = std::uint64_t;
constexpr std::uint32_t kMostGroups = 64;

HWY_INLINE std::uint32_t width() { return static_cast<std::uint32_t>(hn::Lanes(kFloats)); }

// How a packet goes through the tree.
struct Way {
  std::uint32_t octant;    // of most rays
  std::uint32_t mixed;     // bit a: not all rays go the way of the octant along axis a
  std::uint32_t reversal;  // 0, or 7: children from the far end on
};

HWY_INLINE Way way_of(const Packet& p, std::uint32_t octant, bool from_far_end) {
  Way way{octant, 0, from_far_end ? kBvh8Arity - 1 : 0};
  for (std::uint32_t i = 0; i < p.lanes; i += width())
    for (int a = 0; a < 3; ++a) {
      const Mask backwards = hn::Lt(load(p.inv[a] + i), set(0));
      const bool is_octant = (octant >> a & 1u) != 0 ? hn::AllTrue(kFloats, backwards) : hn::AllFalse(kFloats, backwards);
      way.mixed |= is_octant ? 0u : 1u << a;
    }
  return way;
}

// What all rays of a packet have in common.
enum class Share { nothing, way, way_and_origin };

// A child's planes, in all lanes: the ones that rays of the octant meet first, and last; relative to a shared origin.
template <Share kShare>
struct ChildPlanes {
  Floats near_plane[3], far_plane[3];

  HWY_INLINE ChildPlanes(const Packet& p, const Bvh8Node& node, std::uint32_t c, std::uint32_t octant) {
    for (int a = 0; a < 3; ++a) {
      const std::uint32_t side = octant >> a & 1u;
      near_plane[a] = set(node.plane(a, side, c)), far_plane[a] = set(node.plane(a, side ^ 1u, c));
      if constexpr (kShare == Share::way_and_origin) {
        near_plane[a] = hn::Sub(near_plane[a], set(p.origin[a])), far_plane[a] = hn::Sub(far_plane[a], set(p.origin[a]));
      }
    }
  }
};

// Bvh8Ray::enters(), of the rays from lane i on. Reciprocals for far planes are scaled each time: loads are dearer.
template <Share kShare>
HWY_INLINE Mask enter_child(const Packet& p, Way way, std::uint32_t i, const ChildPlanes<kShare>& child) {
  Floats nearer[3], farther[3];
  for (int a = 0; a < 3; ++a) {
    const Floats inv = load(p.inv[a] + i);
    Floats near_plane = child.near_plane[a], far_plane = child.far_plane[a];
    if (kShare == Share::nothing && (way.mixed >> a & 1u) != 0) {
      const Mask backwards = hn::Lt(inv, set(0)), is_octant = (way.octant >> a & 1u) != 0 ? backwards : hn::Not(backwards);
      near_plane = hn::IfThenElse(is_octant, child.near_plane[a], child.far_plane[a]);
      far_plane = hn::IfThenElse(is_octant, child.far_plane[a], child.near_plane[a]);
    }
    if constexpr (kShare != Share::way_and_origin) {
      const Floats org = load(p.org[a] + i);
      near_plane = hn::Sub(near_plane, org), far_plane = hn::Sub(far_plane, org);
    }
    nearer[a] = hn::Mul(near_plane, inv);
    farther[a] = hn::Mul(far_plane, hn::Mul(inv, set(PaddedSlabs::kFarPlaneScale)));
  }
  const Floats limit = hn::Mul(load(p.t + i), set(PaddedSlabs::kEndScale));
  const Floats enter = most(most(nearer[1], nearer[2]), most(nearer[0], load(p.t_min + i)));
  const Floats leave = least(least(farther[1], farther[2]), least(farther[0], limit));
  return hn::Le(enter, leave);
}

// The groups and, of each, the rays that are on their way, as bits.
struct Active {
  GroupBits groups;
  std::uint8_t rays[kMostGroups][8];

  HWY_INLINE static Active all(const Packet& p) {
    Active active;
    active.groups = 0;
    for (std::uint32_t g = 0; g < p.lanes / width(); ++g) {
      const Mask waiting = hn::Ge(load(p.t + g * width()), set(0));
      hn::StoreMaskBits(kFloats, waiting, active.rays[g]);
      active.groups |= static_cast<GroupBits>(!hn::AllFalse(kFloats, waiting)) << g;
    }
    return active;
  }
  // body(group), in ascending order.
  template <class Body>
  static HWY_INLINE void for_each(GroupBits groups, const Body& body) {
    for (; groups != 0; groups &= groups - 1) body(static_cast<std::uint32_t>(std::countr_zero(groups)));
  }
};

// A child whose box the frustum meets, and the groups that reached its parent.
struct Postponed {
  NodeRef node;
  std::uint32_t child;
  GroupBits groups;
};

// Every ray of the groups that enters the child goes there. Returns false if there is none.
template <Share kShare>
HWY_INLINE bool enter(const Postponed& to, const Bvh8Node& node, const Packet& p, Way way, Active& active) {
  const ChildPlanes<kShare> child(p, node, to.child, way.octant);
  active.groups = 0;
  Active::for_each(to.groups, [&](std::uint32_t g) HWY_ATTR {
    const Mask entered = enter_child(p, way, g * width(), child);
    hn::StoreMaskBits(kFloats, entered, active.rays[g]);
    active.groups |= static_cast<GroupBits>(!hn::AllFalse(kFloats, entered)) << g;
  });
  return active.groups != 0;
}

// Returns how many new answers there are.
template <Query kQuery, Share kShare>
HWY_INLINE std::uint32_t intersect_leaf(const TriangleBlock* blocks, NodeRef leaf, const Active& active, Packet& p) {
  std::uint32_t answered = 0;
  const TriangleBlock* block = blocks + first_block(leaf);
  const std::uint32_t count = counted_blocks(leaf);
  for (std::uint32_t b = 0; count != 0 ? b < count : block->has(0); ++b, ++block)
    for (std::uint32_t lane = 0; lane < kBlockLanes && block->has(lane); ++lane) {
      const PackedTriangle triangle = block->packed(lane);
      GroupTest<kQuery, kShare == Share::way_and_origin> test(p, triangle);
      Active::for_each(active.groups, [&](std::uint32_t g) HWY_ATTR {
        answered += test.intersect(g * width(), hn::LoadMaskBits(kFloats, active.rays[g]));
      });
    }
  return answered;
}

// Begins to fetch a node, or the first block of a leaf.
HWY_INLINE void fetch(const Bvh8View& view, NodeRef ref) {
  const char* const at = is_leaf(ref) ? reinterpret_cast<const char*>(view.blocks + first_block(ref))
                                      : reinterpret_cast<const char*>(view.nodes + ref);
  for (std::size_t line = 0; line < sizeof(Bvh8Node); line += 64) hwy::Prefetch(at + line);
}

// The leaf that has stopped most rays of the last packet, which may stop the next one's: they run beside them.
struct Occluder {
  NodeRef leaf = kNoNode;
  std::uint32_t stopped = 0;

  // Of fewer rays than a quarter, the tests cost what they save.
  HWY_INLINE bool is_promising(const Packet& p) const { return 4 * stopped >= p.size; }
};

template <Query kQuery, Share kShare>
HWY_INLINE void trace_packet(const Bvh8View& view, const Frustum& frustum, Way way, Packet& p, Occluder& occluder) {
  Postponed stack[bvh8_stack_size(kMostBvh8Depth)];
  std::size_t size = 0;
  bool is_at_occluder = kQuery == Query::any && occluder.is_promising(p);
  NodeRef ref = is_at_occluder ? occluder.leaf : view.root;
  occluder.stopped = 0;
  Active active = Active::all(p);
  std::uint32_t answered = 0;
  for (;;) {
    if (!is_leaf(ref)) {
      const Bvh8Node& node = view.nodes[ref];
      const std::uint32_t met = boxes_met(node, frustum);
      for (std::uint32_t i = 0; i < kBvh8Arity; ++i) {
        const std::uint32_t c = node.ordered(i ^ way.reversal, way.octant);
        stack[size] = {ref, c, active.groups};
        size += met >> c & 1u;
        if ((met >> c & 1u) != 0) fetch(view, node.child[c]);
      }
    } else {
      const std::uint32_t more = intersect_leaf<kQuery, kShare>(view.blocks, ref, active, p);
      if constexpr (kQuery == Query::any) {
        if (more > occluder.stopped) occluder = {ref, more};
        answered += more;
        if (answered == p.size) return;
        if (is_at_occluder) {
          is_at_occluder = false, ref = view.root, active = Active::all(p);
          continue;
        }
      }
    }
    const Bvh8Node* parent;
    do {
      if (size == 0) return;
      parent = view.nodes + stack[--size].node;
    } while (!enter<kShare>(stack[size], *parent, p, way, active));
    ref = parent->child[stack[size].child];
  }
}

template <Query kQuery, class Answer>
HWY_INLINE void trace_packets(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, bool from_far_end,
                              Answer* answers) {
  Packet packet;
  const Aabb bounds = bounds_of_children(view.nodes[view.root]);
  const std::uint32_t most = std::min(kMostGroups * width(), kMaxPacketSize);
  Occluder occluder;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const std::uint32_t end = batch.packets[batch.active[i] + 1];
    for (std::uint32_t first = batch.packets[batch.active[i]], size; first < end; first += size) {
      size = std::min(end - first, most);
      load_rays(batch.rays, batch.ids + first, size, faces[first] >> 1, packet);
      if constexpr (kQuery == Query::any) packet.reach = reach_of(packet, bounds);
      const Frustum frustum = frustum_of(packet, faces[first], bounds);
      const Way way = way_of(packet, frustum.signs, from_far_end);
      if (way.mixed != 0)
        trace_packet<kQuery, Share::nothing>(view, frustum, way, packet, occluder);
      else if (packet.has_one_origin)
        trace_packet<kQuery, Share::way_and_origin>(view, frustum, way, packet, occluder);
      else
        trace_packet<kQuery, Share::way>(view, frustum, way, packet, occluder);
      for (std::uint32_t r = 0; r < size; ++r) store_answer(packet, r, answers[batch.ids[first + r]]);
    }
  }
}

void intersect(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits) {
  trace_packets<Query::closest>(view, batch, faces, false, hits);
}
void occlude(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, bool from_far_end,
             std::uint8_t* occluded) {
  trace_packets<Query::any>(view, batch, faces, from_far_end, occluded);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(intersect);
HWY_EXPORT(occlude);

void trace_bvh8_packets_simd(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits) {
  HWY_DYNAMIC_DISPATCH(intersect)(view, batch, faces, hits);
}
void trace_bvh8_packets_simd(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces,
                             std::uint8_t* occluded, bool from_far_end) {
  HWY_DYNAMIC_DISPATCH(occlude)(view, batch, faces, from_far_end, occluded);
}
}  // namespace accel
#endif
