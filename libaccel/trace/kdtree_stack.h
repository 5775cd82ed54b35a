// Ordered traversal of a kd-tree with a stack: Foley and Sugerman 2005, "KD-Tree Acceleration Structures for a GPU Raytracer"
// [FS05], section 2.1 and Fig. 2, after Pharr and Humphreys 2004.
//
// Deviations. An entry of the stack has no t_min, for it is the t_max of the leaf before it is popped. The second child is
// pushed whether or not the ray gets there, and an entry whose interval is empty is dropped when it is popped: that takes the
// branch that is hardest to predict out of the descent, and rays that end early never make it (diffuse rays gain 5 to 9 %). How
// [FS05]'s tests are written so that nothing is lost at planes: see kdtree_common.h. All other traversers of the kd-tree visit
// the same leaves in the same order.
#pragma once

#include "libaccel/trace/kdtree_common.h"

namespace accel {

template <class Test, Query kQuery>
struct KdTreeStack : KdTraversal<Test, kQuery> {
  static constexpr const char* kName = "stack";
  using View = KdTreeView;

  // At most one postponed child for each inner node on the path.
  static constexpr std::uint32_t kMaxDepth = kKdStackSize;

  struct Postponed {
    std::uint32_t node;
    float t_max;
  };
  struct Stack {
    Postponed entries[kKdStackSize];
  };
  struct State : KdState<Test> {
    std::uint32_t postponed;  // entries on the stack; unsigned, which saves extending its sign in every step
    Stack* stack;
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    if (!begin_kdtree(view, ray, state, hit)) return Phase::done;
    state.postponed = 0;
    return enter(view, kKdRoot, state, observer);
  }

  // search-split
  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit&, Observer& observer) {
    observer.node_step();
    const KdCrossing plane = crossing(view, state);
    // A branch, not a select: a predicted child is fetched before the distance is known, see bvh2_stack.h.
    if (!(plane.t > state.t_min)) return enter_second(plane, state, observer);
    Postponed& entry = state.stack->entries[state.postponed++];
    observer.store(Memory::stack, &entry, sizeof entry);
    entry = {plane.second(), state.t_max};
    state.t_max = min_of(plane.t, state.t_max);
    return enter_first(plane, state, observer);
  }

  // continue-search
  template <class Observer>
  ACCEL_HD static Phase backtrack(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    if (is_final(hit, state)) return Phase::done;
    state.t_min = state.t_max;
    while (state.postponed > 0) {
      const Postponed& entry = state.stack->entries[--state.postponed];
      observer.load(Memory::stack, &entry, sizeof entry);
      if (!(state.t_min < entry.t_max)) continue;
      observer.backtrack();
      state.t_max = entry.t_max;
      return enter(view, entry.node, state, observer);
    }
    return Phase::done;
  }
};

}  // namespace accel
