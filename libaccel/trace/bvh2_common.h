// What traversers of a Bvh2 without a stack have in common: the ray's part of the state, and how they enter nodes.
#pragma once

#include <cstdint>

#include "libaccel/structure/bvh2.h"
#include "libaccel/trace/box_pair.h"
#include "libaccel/trace/leaf.h"

namespace accel {

template <class Test>
struct Bvh2State {
  BoxPairTest boxes;
  typename Test::RayData test;
  NodeRef node;        // while descending
  std::uint32_t quad;  // in a leaf; after its last triangle, of its terminator
};

// Prepares the hit and the ray's part of the state. False if there is nothing to traverse.
template <class Test>
ACCEL_HD bool begin_bvh2(const Bvh2View& view, const Ray& ray, Bvh2State<Test>& state, Hit& hit) {
  begin_hit(ray, hit);
  if (view.root == kNoNode || !is_traceable(ray)) return false;
  state.boxes = BoxPairTest::prepare(ray, first_t(ray));
  state.test = Test::prepare(ray);
  return true;
}

// Tells the observer that an inner node is visited.
template <class Observer>
ACCEL_HD const Bvh2Node& visit_node(const Bvh2View& view, NodeRef ref, Observer& observer) {
  const Bvh2Node& node = view.nodes[ref];
  observer.node_step();
  observer.load(Memory::node, &node, sizeof node);
  observer.box_tests(2);
  return node;
}

// Which children the ray enters before t_max, and where. A path that keeps more than what is postponed (trace/bvh2_pause.h) is
// told of children behind t_max too.
template <class State>
ACCEL_HD BoxPairHit test_boxes(State& state, const Bvh2Node& node, float t_max) {
  if constexpr (requires { state.meets_both; }) {
    BoxPairHit boxes = state.boxes.intersect(node, state.t_end);
    state.meets_both = boxes.mask == 3;
    boxes.mask &= (boxes.t_near0 <= t_max * kFarScale ? 1u : 0u) | (boxes.t_near1 <= t_max * kFarScale ? 2u : 0u);
    return boxes;
  } else {
    return state.boxes.intersect(node, t_max);
  }
}

template <class Test, class Observer>
ACCEL_HD Phase enter_node(Bvh2State<Test>& state, NodeRef node, Observer& observer) {
  state.node = node;
  state.quad = leaf_quad(node);
  if (!is_leaf(node)) return Phase::descend;
  observer.leaf_visit(state.quad);
  return Phase::intersect;
}

// The child that comes first where the ray enters both: the nearer one.
ACCEL_HD std::uint32_t nearer_child(const BoxPairHit& boxes) { return boxes.t_near1 < boxes.t_near0 ? 1u : 0u; }

}  // namespace accel
