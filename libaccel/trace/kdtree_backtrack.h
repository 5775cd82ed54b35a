// Traversal of a kd-tree without a stack, by parent links: kd-backtrack, Foley and Sugerman 2005, "KD-Tree Acceleration
// Structures for a GPU Raytracer" [FS05], section 2.3.
//
// After a leaf the traversal climbs to the nearest ancestor whose cell reaches beyond the leaf's t_max, and goes on in the
// child of it that it did not come from.
//
// Deviations. [FS05] intersects the ancestor's box and searches the ancestor again; here the box gives the t_max alone, t_min
// being known, and the search goes on in the far child without a step: the interval of the child that the climb came from ended
// at t_min and the ancestor's does not, so the plane between the children was met there. So the inner nodes that are visited on
// the way down are exactly those of the stack version. Cells are bounded by planes of the tree, and leaving them is computed by
// the same expression, so the t_max found is the one that the stack version would have popped, bit for bit. [FS05] stops where
// t_max == global-t_max; here >=.
//
// Progress: the root's cell reaches to the end of the ray or beyond, so every climb ends. Steps: a node is climbed to at most
// once from each child, so up and down together are less than three times the stack version's steps down.
#pragma once

#include "libaccel/trace/kdtree_common.h"

namespace accel {

template <class Test, Query kQuery>
struct KdTreeBacktrack : KdTraversal<Test, kQuery> {
  static constexpr const char* kName = "backtrack";
  using View = KdTreeView;
  static constexpr KdExtras kNeeds = KdExtras::parents_and_boxes;

  struct State : KdState<Test> {
    float t_end;    // global-t_max
    bool climbing;  // from the node at `index`
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    if (!begin_kdtree(view, ray, state, hit)) return Phase::done;
    state.t_end = state.t_max;
    return go_to(view, kKdRoot, state, observer);
  }

  // search-split
  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit&, Observer& observer) {
    observer.node_step();
    const KdCrossing plane = crossing(view, state);
    if (!(plane.t > state.t_min)) return go_to(view, plane.second(), state, observer);
    if (plane.t < state.t_max) state.t_max = plane.t;
    return go_to(view, plane.first(), state, observer);
  }

  // continue-search after a leaf, then backtrack once for each ancestor.
  template <class Observer>
  ACCEL_HD static Phase backtrack(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    if (!state.climbing) {
      if (is_final(hit, state) || state.t_max >= state.t_end) return Phase::done;
      state.t_min = state.t_max;
      state.climbing = true;
      return Phase::backtrack;
    }
    observer.backtrack();
    ACCEL_ASSERT(state.index != kKdRoot);
    const Aabb& cell = view.cells[pair_of(state.index)];  // the parent's
    observer.load(Memory::node, &cell, sizeof cell);
    observer.box_tests(1);
    state.t_max = state.ray.exit(cell, state.t_end);
    if (state.t_max > state.t_min) return go_to(view, sibling_of(state.index), state, observer);
    observer.load(Memory::node, view.parents + pair_of(state.index), sizeof(std::uint32_t));
    state.index = view.parents[pair_of(state.index)];
    return Phase::backtrack;
  }

 private:
  template <class Observer>
  ACCEL_HD static Phase go_to(const View& view, std::uint32_t index, State& state, Observer& observer) {
    state.climbing = false;
    return enter(view, index, state, observer);
  }
};

}  // namespace accel
