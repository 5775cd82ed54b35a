// What the traversers of the kd-tree share: the ray's interval, and how it enters nodes.
//
// Everything that a traverser decides about a plane rests on one number, its distance (trace/cell_ray.h), and on one rule
// (Foley and Sugerman 2005, Fig. 2, search-split):
//
//     not distance > t_min      the second child alone     (the one that the ray reaches later)
//     not distance < t_max      the first child alone
//     else                      the first child up to the distance, then the second child from there
//
// The distance is monotone in the plane, so the intervals of cells follow one another without gaps or overlaps, and the
// interval of a cell is the same whether it is found by descent from the root, or from the cell's faces, as some traversers
// without a stack do: bit for bit. Each interval has a length: two planes that are met at one distance have no cell between
// them. (An interval that is a single point from the start visits one cell.) Of a plane that contains the ray, whose distance
// is NaN, the rule visits the second child alone.
//
// A hit is final when it is nearer than the end of the leaf's interval: structure/padding.h says why all triangles that could
// be met before, or at the same distance, are then among those already tested.
#pragma once

#include <cstdint>

#include "libaccel/structure/kdtree.h"
#include "libaccel/trace/cell_ray_simd.h"
#include "libaccel/trace/reference_leaf.h"
#include "libaccel/trace/traverser.h"

namespace accel {

// Of the tests in trees with perfect splits, 4 % (Sponza, primary rays) to 11 % (BART kitchen, primary rays) repeat an earlier
// test of the ray, which is 0.2 to 0.6 tests a ray. A ring of the last four slots would avoid 2 % to 10 %.
inline constexpr SkippedFeature kNoMailbox{
    "mailbox", "skipped, because perfect splits leave few triangles to be tested twice, and looking them up delays every test"};

// What every traverser of the kd-tree carries.
template <class Test>
struct KdState {
  CellRay ray;
  typename Test::RayData test;
  float t_min, t_max;         // the ray's interval in the current node
  const KdNode* at;           // the current node
  std::uint32_t index;        // of the current node
  std::uint32_t first_bytes;  // ray.backwards_axes in bytes of nodes: sizeof(KdNode) in place of 1
  KdNode node;                // what it holds; on hosts, the link only: see payload_of()
  std::uint32_t reference;    // in a leaf

  // Member by member, for GCC clears what has arrays that are indexed at run time as a whole, in memory and slowly.
  ACCEL_HD KdState() : ray{}, test{}, t_min(0), t_max(0), at(nullptr), index(0), first_bytes(0), node{}, reference(0) {}
};

// Prepares hit and state. False for rays that miss the scene's box.
template <class Test>
ACCEL_HD bool begin_kdtree(const KdTreeView& view, const Ray& ray, KdState<Test>& state, Hit& hit) {
  begin_hit(ray, hit);
  if (view.nodes == nullptr || !is_traceable(ray)) return false;
  float t_min = first_t(ray), t_max = hit.t;
  const CellRay cells = enter_box(ray, view.bounds, t_min, t_max);
  state.t_min = t_min, state.t_max = t_max;
  // Number by number, for GCC copies the whole slowly.
  for (int a = 0; a < 3; ++a) state.ray.org[a] = cells.org[a], state.ray.inv_dir[a] = cells.inv_dir[a];
  state.ray.backwards_axes = cells.backwards_axes, state.ray.t_anchor = cells.t_anchor, state.ray.t_unit = cells.t_unit;
  state.first_bytes = cells.backwards_axes * static_cast<std::uint32_t>(sizeof(KdNode));
  state.test = Test::prepare(ray);
  return state.t_min <= state.t_max;
}

// The first word of the node that the state is in. Devices load nodes whole. Hosts load it where it is used: the plane goes
// straight to a register for floats, and the branch that it decides, which is the one that is hardest to predict, is decided
// that much earlier.
template <class Test>
ACCEL_HD std::uint32_t payload_of(const KdState<Test>& state) {
  return is_device_code() ? state.node.payload : state.at->payload;
}

// Where the ray meets the plane of an inner node, and its children, the first of which is on the side where the ray is before.
struct KdCrossing {
  float t;
  const KdNode* children;     // the lower one, which the upper one follows
  std::uint32_t lower;        // its index
  std::uint32_t first_bytes;  // from it to the first child: 0 or sizeof(KdNode)

  ACCEL_HD std::uint32_t first() const { return lower + first_bytes / static_cast<std::uint32_t>(sizeof(KdNode)); }
  ACCEL_HD std::uint32_t second() const { return sibling_of(first()); }
};
template <class Test>
ACCEL_HD KdCrossing crossing(const KdTreeView& view, const KdState<Test>& state) {
  const KdNode node{payload_of(state), state.node.link};
  // Children begin at even indices, so bit 2 of the link is 0 and bits 3 and 4 are anyone's: masking them would take time.
  const std::uint32_t first_bytes = state.first_bytes >> (node.link & 31u) & sizeof(KdNode);
  return {state.ray.crossing(node.axis(), node.plane()), view.nodes + node.lower_child(), node.lower_child(), first_bytes};
}

// Reaches the leaf that the state is in, and tells the phase that it calls for.
template <class Test, class Observer>
ACCEL_HD Phase enter_leaf(KdState<Test>& state, Observer& observer) {
  observer.leaf_visit(state.index);
  state.reference = payload_of(state);
  return state.reference == kEmptyLeaf ? Phase::backtrack : Phase::intersect;
}

// Goes to the node `at`, whose index is `index`.
template <class Test, class Observer>
ACCEL_HD void load_node(const KdNode* at, std::uint32_t index, KdState<Test>& state, Observer& observer) {
  state.index = index, state.at = at;
  if (is_device_code()) {
    state.node = load_8_bytes(*at);
  } else {
    state.node.link = at->link;
  }
  observer.load(Memory::node, at, sizeof(KdNode));
}

// Goes to a node, and tells the phase that it calls for.
template <class Test, class Observer>
ACCEL_HD Phase enter(const KdNode* at, std::uint32_t index, KdState<Test>& state, Observer& observer) {
  load_node(at, index, state, observer);
  return state.node.is_leaf() ? enter_leaf(state, observer) : Phase::descend;
}
template <class Test, class Observer>
ACCEL_HD Phase enter(const KdTreeView& view, std::uint32_t index, KdState<Test>& state, Observer& observer) {
  return enter(view.nodes + index, index, state, observer);
}

// Go to a child. Where branches are predicted, a ray waits for the links on its path, each of which comes from the address that
// the one before has named. That address is made of bytes: GCC would make it from the index, which is known two steps later.
ACCEL_HD const KdNode* child_at(const KdCrossing& plane, std::uint32_t bytes) {
  return reinterpret_cast<const KdNode*>(reinterpret_cast<const char*>(plane.children) + bytes);
}
template <class Test, class Observer>
ACCEL_HD Phase enter_first(const KdCrossing& plane, KdState<Test>& state, Observer& observer) {
  return enter(child_at(plane, plane.first_bytes), plane.first(), state, observer);
}
template <class Test, class Observer>
ACCEL_HD Phase enter_second(const KdCrossing& plane, KdState<Test>& state, Observer& observer) {
  return enter(child_at(plane, plane.first_bytes ^ sizeof(KdNode)), plane.second(), state, observer);
}

// Whether no triangle beyond the current leaf can be met before the hit.
template <class Test>
ACCEL_HD bool is_final(const Hit& hit, const KdState<Test>& state) {
  return hit.t < state.ray.ray_t(state.t_max);
}

// What the traversers' types have in common: leaves.
template <class Test, Query kQuery>
struct KdTraversal {
  static constexpr SkippedFeature kSkips = kNoMailbox;

  // For speculation: see trace/traverser.h.
  static constexpr Phase kAfterLeaf = Phase::backtrack;
  ACCEL_HD static std::uint32_t& leaf(KdState<Test>& state) { return state.reference; }

  // search-leaf
  template <class Observer>
  ACCEL_HD static Phase intersect(const KdTreeView& view, const Ray& ray, KdState<Test>& state, Hit& hit, Observer& observer) {
    return intersect_next<Test, kQuery>(view.leaves, ray, state.test, first_t(ray), state.reference, hit, kAfterLeaf, observer);
  }
};

}  // namespace accel
