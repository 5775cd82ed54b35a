// Traversal of a kd-tree from leaf to leaf: Popov, Guenther, Seidel and Slusallek 2007, "Stackless KD-Tree Traversal for High
// Performance GPU Ray Tracing".
//
// A leaf knows its cell and, for each face, a rope: the smallest subtree that holds all leaves behind the face. From the leaf
// in which the ray begins, the traversal leaves each leaf through the face that the ray meets first, follows its rope, and
// descends to the leaf where the ray goes on.
//
// Deviations. The descent compares distances along the ray with t_min, not the entry point's coordinates with planes, so its
// decisions are those of the other traversers. Where the ray leaves a cell through an edge or a corner, to within rounding, the
// leaf behind one face may end where the ray enters it: such leaves are passed through, not visited. So the leaves visited are
// those of the stack version, in the same order.
//
// Progress: every rope crosses one more plane in the ray's direction.
#pragma once

#include "libaccel/trace/kdtree_common.h"

namespace accel {

template <class Test, Query kQuery>
struct KdTreeRopes : KdTraversal<Test, kQuery> {
  static constexpr const char* kName = "ropes";
  using View = KdTreeView;
  static constexpr KdExtras kNeeds = KdExtras::ropes;

  struct State : KdState<Test> {
    float t_end;
    std::uint32_t rope;  // of the face through which the ray leaves the leaf
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    if (!begin_kdtree(view, ray, state, hit)) return Phase::done;
    state.t_end = state.t_max;
    return go_to(view, kKdRoot, state, observer);
  }

  // Point location, by distances.
  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit&, Observer& observer) {
    observer.node_step();
    const KdCrossing plane = crossing(view, state);
    if (!(plane.t > state.t_min)) return go_to(view, plane.second(), state, observer);
    return go_to(view, plane.first(), state, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    if (is_final(hit, state) || state.t_max >= state.t_end) return Phase::done;
    observer.backtrack();
    state.t_min = state.t_max;
    return go_to(view, state.rope, state, observer);
  }

 private:
  template <class Observer>
  ACCEL_HD static Phase go_to(const View& view, std::uint32_t index, State& state, Observer& observer) {
    load_node(view.nodes + index, index, state, observer);
    if (!state.node.is_leaf()) return Phase::descend;
    find_exit(view.ropes[state.node.ordinal()], state, observer);
    const bool is_passed_through = !(state.t_min < state.t_max) && state.t_max < state.t_end;
    return is_passed_through ? Phase::backtrack : enter_leaf(state, observer);
  }

  // Where the ray leaves the leaf's cell, and the rope of that face. At the border of the tree the ray has ended.
  template <class Observer>
  ACCEL_HD static void find_exit(const LeafRopes& neighbours, State& state, Observer& observer) {
    observer.load(Memory::node, &neighbours.cell, sizeof neighbours.cell);
    state.t_max = state.t_end;
    int face = -1;
    for (int a = 0; a < 3; ++a) {
      const float t = state.ray.crossing(a, state.ray.exit_face(neighbours.cell, a));
      if (!(t < state.t_max)) continue;
      state.t_max = t;
      face = state.ray.backwards(a) != 0 ? a : a + 3;
    }
    ACCEL_ASSERT(state.t_min <= state.t_max);
    if (face < 0) return;
    observer.load(Memory::node, neighbours.rope + face, sizeof neighbours.rope[face]);
    state.rope = neighbours.rope[face];
    ACCEL_ASSERT(state.rope != kNoRope);
  }
};

}  // namespace accel
