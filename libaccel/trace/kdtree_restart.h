// Traversal of a kd-tree without a stack, from the root for every leaf: kd-restart, Foley and Sugerman 2005, "KD-Tree
// Acceleration Structures for a GPU Raytracer" [FS05], section 2.2.
//
// Where the stack version would push, nothing is kept: the leaf's t_max is the t_min of what follows, so a descent from the
// root with the interval that is left finds the next leaf. Needs no arrays beyond the nodes.
//
// Deviation: [FS05] stops where t_max == global-t_max; here >=. Progress: a restart's interval is never empty and begins where
// the last leaf ended, and the leaf that it finds has a length (kdtree_common.h), so t_min grows with every leaf.
// Steps: at most leaves visited times depth.
#pragma once

#include "libaccel/trace/kdtree_common.h"

namespace accel {

template <class Test, Query kQuery>
struct KdTreeRestart : KdTraversal<Test, kQuery> {
  static constexpr const char* kName = "restart";
  using View = KdTreeView;

  struct State : KdState<Test> {
    float t_end;  // global-t_max
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    if (!begin_kdtree(view, ray, state, hit)) return Phase::done;
    state.t_end = state.t_max;
    return enter(view, kKdRoot, state, observer);
  }

  // search-split
  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit&, Observer& observer) {
    observer.node_step();
    const KdCrossing plane = crossing(view, state);
    if (!(plane.t > state.t_min)) return enter_second(plane, state, observer);
    if (plane.t < state.t_max) state.t_max = plane.t;
    return enter_first(plane, state, observer);
  }

  // continue-search
  template <class Observer>
  ACCEL_HD static Phase backtrack(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    if (is_final(hit, state) || state.t_max >= state.t_end) return Phase::done;
    observer.backtrack();
    ACCEL_ASSERT(state.t_min < state.t_max);
    state.t_min = state.t_max, state.t_max = state.t_end;
    return enter(view, kKdRoot, state, observer);
  }
};

}  // namespace accel
