// Ordered traversal of a Bvh2 with a stack: Aila and Laine 2009, "Understanding the Efficiency of Ray Traversal on GPUs",
// section 3.
//
// Both children's boxes are tested at their parent; the nearer child comes next, the farther one is postponed on the stack
// together with its entry distance, so that it can be dropped unread when a nearer hit has been found meanwhile.
//
// kDropPostponed switches that off: what traversers without a stack visit, which have no room for distances, is then what this
// one visits, node by node (validation/conformance/bvh2_laws_test.cpp). Boxes is the test of both boxes: bench/trace_bench.cpp
// asks what the one in SIMD lanes is worth.
#pragma once

#include "libaccel/trace/box_pair.h"
#include "libaccel/trace/leaf.h"

namespace accel {

template <class Test, Query kQuery, bool kDropPostponed, class Boxes = BoxPairTest>
struct Bvh2StackWith {
  static constexpr const char* kName = "stack";
  using View = Bvh2View;

  // One postponed child for each inner node on the path.
  static constexpr std::uint32_t kMaxDepth = kBvh2StackSize;

  // For speculation: see trace/traverser.h.
  static constexpr Phase kAfterLeaf = Phase::backtrack;

  struct Postponed {
    NodeRef node;
    float t_near;
  };
  struct Stack {
    Postponed entries[kBvh2StackSize];
  };
  struct State {
    Boxes boxes;
    typename Test::RayData test;
    NodeRef node;        // while descending
    std::uint32_t quad;  // in a leaf
    int postponed;       // entries on the stack
    Stack* stack;
  };

  ACCEL_HD static std::uint32_t& leaf(State& state) { return state.quad; }
  ACCEL_HD static Phase end_leaf(const View&, State&, const Hit&) { return kAfterLeaf; }  // see trace/two_level.h

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    begin_hit(ray, hit);
    if (view.root == kNoNode || !is_traceable(ray)) return Phase::done;
    state.boxes = Boxes::prepare(ray, first_t(ray));
    state.test = Test::prepare(ray);
    state.postponed = 0;
    return enter(state, view.root, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    const Bvh2Node& node = view.nodes[state.node];
    observer.node_step();
    observer.load(Memory::node, &node, sizeof node);
    observer.box_tests(2);
    const BoxPairHit boxes = state.boxes.intersect(node, hit.t);
    // Branches, not selects: a predicted child is fetched before its distances are known, which doubles the speed of coherent
    // rays. One child or two is asked before which one, which is another 1 % (primary rays) to 3 % (diffuse).
    if (boxes.mask == 0) return Phase::backtrack;
    if (boxes.mask != 3) {
      if (boxes.mask == 1) return enter(state, node.child[0], observer);
      return enter(state, node.child[1], observer);
    }
    Postponed& entry = state.stack->entries[state.postponed++];
    observer.store(Memory::stack, &entry, sizeof entry);
    if (boxes.t_near1 < boxes.t_near0) {
      entry = {node.child[0], boxes.t_near0};
      return enter(state, node.child[1], observer);
    }
    entry = {node.child[1], boxes.t_near1};
    return enter(state, node.child[0], observer);
  }

  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    return intersect_next<Test, kQuery>(view.leaves, ray, s.test, s.boxes.t_min, s.quad, hit, kAfterLeaf, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View&, const Ray&, State& state, [[maybe_unused]] Hit& hit, Observer& observer) {
    if (state.postponed == 0) return Phase::done;
    observer.backtrack();
    const Postponed& entry = state.stack->entries[--state.postponed];
    observer.load(Memory::stack, &entry, sizeof entry);
    return !kDropPostponed || entry.t_near <= hit.t * kFarScale ? enter(state, entry.node, observer) : Phase::backtrack;
  }

 private:
  template <class Observer>
  ACCEL_HD static Phase enter(State& state, NodeRef node, Observer& observer) {
    state.node = node;
    state.quad = leaf_quad(node);
    if (!is_leaf(node)) return Phase::descend;
    observer.leaf_visit(state.quad);
    return Phase::intersect;
  }
};

template <class Test, Query kQuery>
struct Bvh2Stack : Bvh2StackWith<Test, kQuery, true> {};

}  // namespace accel
