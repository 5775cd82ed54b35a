// Traversal of a Bvh2 without a stack, by links to parents and siblings: Afra and Szirmay-Kalos 2014, "Stackless Multi-BVH
// Traversal for CPU, MIC and GPU Ray Tracing", for two children.
//
// A bit trail says on which levels the farther child was postponed. The traversal climbs from parent to parent until the last
// bit of the trail is set, and crosses over to the sibling; it is finished when no bit is left. Nodes visited on the way down
// are those of bvh2_hash.h.
#pragma once

#include "libaccel/trace/bvh2_common.h"
#include "libaccel/trace/node_path.h"

namespace accel {

template <class Test, Query kQuery, class Path>
struct Bvh2SiblingWith : Path::Traits {
  static constexpr const char* kName = "sibling";
  using View = Bvh2View;
  static constexpr Bvh2Extras kNeeds = Bvh2Extras::parents;

  struct State : Bvh2State<Test>, Path {
    NodeRef parent, sibling;  // of the node that the traversal is in, once it has to go back
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    if (!begin_bvh2(view, ray, state, hit)) return Phase::done;
    state.Path::begin();
    state.parent = state.sibling = kNoNode;
    return enter_node(state, view.root, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    const Bvh2Node& node = visit_node(view, state.node, observer);
    const BoxPairHit boxes = test_boxes(state, node, hit.t);
    // Branches, not selects: see bvh2_stack.h.
    if (boxes.mask == 0) {
      state.parent = node.link[0], state.sibling = node.link[1];
      return Phase::backtrack;
    }
    if (boxes.mask == 1) return go_down(node, 0, false, state, observer);
    if (boxes.mask == 2) return go_down(node, 1, false, state, observer);
    if (boxes.t_near1 < boxes.t_near0) return go_down(node, 1, true, state, observer);
    return go_down(node, 0, true, state, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    const Phase next =
        intersect_next<Test, kQuery>(view.leaves, ray, s.test, s.boxes.t_min, s.quad, hit, Phase::backtrack, observer);
    if (next == Phase::backtrack) s.parent = view.leaves[s.quad].link[0], s.sibling = view.leaves[s.quad].link[1];
    return next;
  }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View& view, const Ray&, State& state, Hit&, Observer& observer) {
    if (state.is_finished()) return Phase::done;
    observer.backtrack();
    if (state.is_postponed(0)) {
      state.cross();
      return enter_node(state, state.sibling, observer);
    }
    if (state.parent == kNoNode) return Phase::done;  // halves of a deep path may be without bits
    state.rise(1, observer);
    const Bvh2Node& node = view.nodes[state.parent];
    observer.load(Memory::node, node.link, sizeof node.link);
    state.parent = node.link[0], state.sibling = node.link[1];
    return Phase::backtrack;
  }

 private:
  template <class Observer>
  ACCEL_HD static Phase go_down(const Bvh2Node& node, std::uint32_t side, bool postponed, State& state, Observer& observer) {
    state.step_down(side, postponed, 0, observer);  // only paused traversals read the turns; compilers see that
    return enter_node(state, node.child[side], observer);
  }
};

// The method, for trees of any depth.
template <class Test, Query kQuery>
struct Bvh2Sibling : Bvh2SiblingWith<Test, kQuery, DeepPath> {
  using Specialisations =
      TypeList<Bvh2SiblingWith<Test, kQuery, NodePath<std::uint32_t>>, Bvh2SiblingWith<Test, kQuery, NodePath<std::uint64_t>>>;
};

}  // namespace accel
