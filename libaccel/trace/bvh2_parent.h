// Traversal of a Bvh2 without a stack, by links to parents: Hapala, Davidovic, Wald, Havran and Slusallek 2011, "Efficient
// Stack-less BVH Traversal for Ray Tracing".
//
// Nothing is remembered but the node: on the way back every ancestor's boxes are tested again, which tells whether the child
// that the traversal comes from was the first of two. The state is the smallest of all, and trees may have any depth.
//
// Deviation: nodes hold the boxes of their children, so both are decided upon at the parent and the paper's state "from
// sibling" is not needed. Entry distances do not depend on hits, so the order found again is that of the way down; and a child
// that a nearer hit has culled meanwhile is culled exactly where the stack version drops it. So the nodes visited on the way
// down are those of the stack version, in the same order.
#pragma once

#include "libaccel/trace/bvh2_common.h"

namespace accel {

template <class Test, Query kQuery>
struct Bvh2Parent {
  static constexpr const char* kName = "parent";
  using View = Bvh2View;
  static constexpr Bvh2Extras kNeeds = Bvh2Extras::parents;

  struct State : Bvh2State<Test> {
    NodeRef parent;  // of the node that the traversal is in or comes from
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    if (!begin_bvh2(view, ray, state, hit)) return Phase::done;
    return go_to(view.root, kNoNode, state, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    const NodeRef self = state.node;
    const Bvh2Node& node = visit_node(view, self, observer);
    const BoxPairHit boxes = state.boxes.intersect(node, hit.t);
    // Branches, not selects: see bvh2_stack.h.
    if (boxes.mask == 0) return Phase::backtrack;
    if (boxes.mask == 1) return go_to(node.child[0], self, state, observer);
    if (boxes.mask == 2) return go_to(node.child[1], self, state, observer);
    if (boxes.t_near1 < boxes.t_near0) return go_to(node.child[1], self, state, observer);
    return go_to(node.child[0], self, state, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    return intersect_next<Test, kQuery>(view.leaves, ray, s.test, s.boxes.t_min, s.quad, hit, Phase::backtrack, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    if (state.parent == kNoNode) return Phase::done;
    observer.backtrack();
    const Bvh2Node& node = view.nodes[state.parent];
    observer.load(Memory::node, &node, sizeof node);
    observer.box_tests(2);
    const BoxPairHit boxes = state.boxes.intersect(node, hit.t);
    const std::uint32_t first = nearer_child(boxes), second = first ^ 1u;
    if (state.node == node.child[first] && (boxes.mask >> second & 1u) != 0)
      return go_to(node.child[second], state.parent, state, observer);
    state.node = state.parent;
    state.parent = node.link[0];
    return Phase::backtrack;
  }

 private:
  template <class Observer>
  ACCEL_HD static Phase go_to(NodeRef node, NodeRef parent, State& state, Observer& observer) {
    state.parent = parent;
    return enter_node(state, node, observer);
  }
};

}  // namespace accel
