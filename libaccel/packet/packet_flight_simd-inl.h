// Packets on their way through a Bvh8: see packet/bvh8_packets_simd.h. The guard lets the header through once for each target
// that Highway compiles.
#if defined(ACCEL_PACKET_FLIGHT_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_PACKET_FLIGHT_SIMD_INL_H
#undef ACCEL_PACKET_FLIGHT_SIMD_INL_H
#else
#define ACCEL_PACKET_FLIGHT_SIMD_INL_H
#endif

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <bit>
#include <cstdint>

#include "libaccel/packet/frustum_boxes_simd-inl.h"
#include "libaccel/packet/frustum_simd-inl.h"
#include "libaccel/packet/packet_simd-inl.h"
#include "libaccel/packet/pencil_simd-inl.h"
#include "libaccel/packet/watertight_simd-inl.h"
#include "libaccel/structure/two_level_bvh8.h"
#include "libaccel/trace/bvh8_ray.h"
#include "libaccel/trace/bvh8_simd.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE std::uint32_t first_of(GroupBits groups) { return static_cast<std::uint32_t>(std::countr_zero(groups)); }

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
};

// A child, and the groups at its parent that may meet its box.
struct Postponed {
  NodeRef node;
  std::uint32_t child;
  GroupBits groups;
};

// Every ray of the groups that enters the child goes there. Returns false if there is none.
template <Share kShare>
HWY_INLINE bool enter(const Postponed& to, const Bvh8Node& node, const Packet& p, Way way, Active& active) {
  const ChildPlanes<kShare> child(p, node, to.child, way.octant);
  GroupBits groups = 0;
  for (GroupBits rest = to.groups; rest != 0; rest &= rest - 1) {
    const std::uint32_t g = first_of(rest);
    const Mask entered = enter_child(p, way, g * width(), child);
    hn::StoreMaskBits(kFloats, entered, active.rays[g]);
    groups |= static_cast<GroupBits>(!hn::AllFalse(kFloats, entered)) << g;
  }
  active.groups = groups;
  return groups != 0;
}

// Returns how many new answers there are.
template <Query kQuery, class Triangle>
HWY_INLINE std::uint32_t intersect_triangle(const Triangle& triangle, const Active& active, Packet& p) {
  std::uint32_t answered = 0;
  GroupTest<kQuery, Triangle> test(p, triangle);
  for (GroupBits rest = active.groups; rest != 0; rest &= rest - 1) {
    const std::uint32_t g = first_of(rest);
    answered += test.intersect(g * width(), hn::LoadMaskBits(kFloats, active.rays[g]));
  }
  return answered;
}

template <Query kQuery, Share kShare>
HWY_INLINE std::uint32_t intersect_block(const TriangleBlock& block, const Active& active, Packet& p) {
  std::uint32_t answered = 0;
  if constexpr (kShare == Share::way_and_origin) {
    const RelativeVertices vertices(block, p.origin);
    for (std::uint32_t lane = 0; lane < kBlockLanes && block.has(lane); ++lane)
      answered += intersect_triangle<kQuery>(RelativeTriangle{block, vertices, lane}, active, p);
  } else {
    for (std::uint32_t lane = 0; lane < kBlockLanes && block.has(lane); ++lane) {
      const PackedTriangle triangle = block.packed(lane);
      answered += intersect_triangle<kQuery>(LoneTriangle{triangle}, active, p);
    }
  }
  return answered;
}

template <Query kQuery, Share kShare>
HWY_INLINE std::uint32_t intersect_leaf(const TriangleBlock* blocks, NodeRef leaf, const Active& active, Packet& p) {
  std::uint32_t answered = 0;
  const TriangleBlock* block = blocks + first_block(leaf);
  const std::uint32_t count = counted_blocks(leaf);
  for (std::uint32_t b = 0; count != 0 ? b < count : block->has(0); ++b, ++block)
    answered += intersect_block<kQuery, kShare>(*block, active, p);
  return answered;
}

// What a reference names: a node, or the first block of a leaf, or an instance.
HWY_INLINE const char* place_of(const Bvh8View& view, NodeRef ref) {
  return is_leaf(ref) ? reinterpret_cast<const char*>(view.blocks + first_block(ref))
                      : reinterpret_cast<const char*>(view.nodes + ref);
}
HWY_INLINE const char* place_of(const TwoLevelBvh8View& view, NodeRef ref) {
  return is_instance(ref) ? reinterpret_cast<const char*>(view.instances + instance_number(ref)) : place_of(view.top(), ref);
}
// Begins to fetch it.
template <class View>
HWY_INLINE void fetch(const View& view, NodeRef ref) {
  const char* const at = place_of(view, ref);
  for (std::size_t line = 0; line < sizeof(Bvh8Node); line += 64) hwy::Prefetch(at + line);
}

// The leaf that has stopped most rays of the last packet, which may stop the next one's: they run beside them.
struct Occluder {
  NodeRef leaf = kNoNode;
  std::uint32_t stopped = 0;

  // Of fewer rays than a quarter, the tests cost what they save.
  HWY_INLINE bool is_promising(const Packet& p) const { return 4 * stopped >= p.size; }
};

// A packet on its way.
struct Flight {
  Packet packet;
  Frustum frustum;
  Pencil pencil;  // of Share::way_and_origin
  Way way;
  Share share;
  NodeRef ref;             // what comes next: a node or a leaf
  Active active;           // at `ref`
  std::uint32_t answered;  // rays
  std::size_t size;        // of the stack
  Postponed stack[bvh8_stack_size(kMostBvh8Depth)];

  HWY_INLINE Share shared() const {
    if (way.mixed != 0) return Share::nothing;
    return packet.has_one_origin ? Share::way_and_origin : Share::way;
  }
};

// Pushes the children of a node, the nearest last, and begins to fetch them.
template <Share kShare, class View>
HWY_INLINE void push_children(const View& view, Flight& f) {
  const Bvh8Node& node = view.nodes[f.ref];
  const GroupBits here = f.active.groups;
  ChildSlopes slopes;
  std::uint32_t met;
  if constexpr (kShare == Share::way_and_origin)
    met = f.pencil.project(node, slopes);
  else
    met = boxes_met(node, f.frustum);
  for (std::uint32_t rest = met; rest != 0; rest &= rest - 1) fetch(view, node.child[std::countr_zero(rest)]);
  std::size_t size = f.size;
  for (std::uint32_t i = 0; i < kBvh8Arity; ++i) {
    const std::uint32_t c = node.ordered(i ^ f.way.reversal, f.way.octant);
    if constexpr (kShare == Share::way_and_origin) {
      if ((met >> c & 1u) == 0) continue;
      const GroupBits groups = f.pencil.groups_that_meet(slopes, c, here);
      f.stack[size] = {f.ref, c, groups};
      size += groups != 0 ? 1 : 0;
    } else {
      f.stack[size] = {f.ref, c, here};
      size += met >> c & 1u;
    }
  }
  f.size = size;
}

// What is at the leaves of a tree, and what is remembered of it. Those of a Bvh8 are triangles.
template <Query kQuery, class View>
class Leaves;

template <Query kQuery>
class Leaves<kQuery, Bvh8View> {
 public:
  // Returns how many new answers there are.
  template <Share kShare>
  HWY_INLINE std::uint32_t intersect(const Bvh8View& view, Flight& f) {
    const std::uint32_t more = intersect_leaf<kQuery, kShare>(view.blocks, f.ref, f.active, f.packet);
    if constexpr (kQuery == Query::any)
      if (more > occluder_.stopped) occluder_ = {f.ref, more};
    return more;
  }

  // Of any-hit queries, before anything else is asked. Returns how many rays are stopped. The packet's own best leaf takes the
  // place of the one that is asked.
  HWY_INLINE std::uint32_t ask_occluder(const Bvh8View& view, Packet& p) {
    if (!occluder_.is_promising(p)) return occluder_.stopped = 0;
    const Active all = Active::all(p);
    occluder_.stopped = p.has_one_origin ? intersect_leaf<kQuery, Share::way_and_origin>(view.blocks, occluder_.leaf, all, p)
                                         : intersect_leaf<kQuery, Share::nothing>(view.blocks, occluder_.leaf, all, p);
    return occluder_.stopped;
  }

 private:
  Occluder occluder_;
};

// Whose rays are loaded, in front of a tree within `bounds`.
HWY_INLINE void begin(Flight& f, NodeRef root, std::uint32_t face, const Aabb& bounds, bool from_far_end) {
  f.frustum = frustum_of(f.packet, face, bounds);
  f.way = way_of(f.packet, f.frustum.signs, from_far_end);
  f.share = f.shared();
  if (f.share == Share::way_and_origin) f.pencil.begin(f.packet, f.frustum);
  f.ref = root, f.active = Active::all(f.packet), f.size = 0;
}

// To where memory is waited for: the next node's children. Returns false at the end.
template <Query kQuery, Share kShare, class View>
HWY_NOINLINE bool go_on_sharing(const View& view, Flight& f, Leaves<kQuery, View>& leaves) {
  for (;;) {
    const bool is_node = !is_leaf(f.ref);
    if (is_node) {
      push_children<kShare>(view, f);
    } else {
      const std::uint32_t more = leaves.template intersect<kShare>(view, f);
      if constexpr (kQuery == Query::any) {
        f.answered += more;
        if (f.answered == f.packet.size) return false;
      }
    }
    const Bvh8Node* parent;
    do {
      if (f.size == 0) return false;
      parent = view.nodes + f.stack[--f.size].node;
    } while (!enter<kShare>(f.stack[f.size], *parent, f.packet, f.way, f.active));
    f.ref = parent->child[f.stack[f.size].child];
    if (is_node) return true;
  }
}
template <Query kQuery, class View>
HWY_INLINE bool go_on(const View& view, Flight& f, Leaves<kQuery, View>& leaves) {
  switch (f.share) {
    case Share::nothing:
      return go_on_sharing<kQuery, Share::nothing>(view, f, leaves);
    case Share::way:
      return go_on_sharing<kQuery, Share::way>(view, f, leaves);
    default:
      return go_on_sharing<kQuery, Share::way_and_origin>(view, f, leaves);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
