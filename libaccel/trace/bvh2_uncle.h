// Traversal of a Bvh2 without a stack, by links to uncles and grand-uncles: the iterative variant of Binder and Keller 2016,
// "Efficient Stackless Hierarchy Traversal on GPUs with Backtracking in Constant Time", section 2.2.1.
//
// As bvh2_hash.h, but where the register for the most recently postponed node is empty the traversal climbs two levels a step:
// to the grand-uncle, from whose links it goes on, until one of them names a postponed node. Nodes visited on the way down are
// those of bvh2_hash.h. The links of a leaf that is climbed over are in its first triangle (structure/bvh2.h).
#pragma once

#include "libaccel/trace/bvh2_common.h"
#include "libaccel/trace/node_path.h"

namespace accel {

template <class Test, Query kQuery, class Path>
struct Bvh2UncleWith : Path::Traits {
  static constexpr const char* kName = "uncle";
  using View = Bvh2View;
  static constexpr Bvh2Extras kNeeds = Bvh2Extras::uncles;

  struct State : Bvh2State<Test>, Path {
    NodeRef recent;              // the most recently postponed node, or kNoNode
    NodeRef uncle, grand_uncle;  // of the node that the traversal climbs from
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    if (!begin_bvh2(view, ray, state, hit)) return Phase::done;
    state.Path::begin();
    state.recent = state.uncle = state.grand_uncle = kNoNode;
    return enter_node(state, view.root, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    const Bvh2Node& node = visit_node(view, state.node, observer);
    const BoxPairHit boxes = test_boxes(state, node, hit.t);
    // Branches, not selects: see bvh2_stack.h.
    if (boxes.mask == 3) {
      if (boxes.t_near1 < boxes.t_near0) return postpone(node, 0, state, observer);
      return postpone(node, 1, state, observer);
    }
    if (boxes.mask == 0) return leave(node.link, state);
    recall(node.link, state);
    if (boxes.mask == 1) return go_down(node, 0, false, state, observer);
    return go_down(node, 1, false, state, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    const Phase next =
        intersect_next<Test, kQuery>(view.leaves, ray, s.test, s.boxes.t_min, s.quad, hit, Phase::backtrack, observer);
    return next == Phase::backtrack ? leave(view.leaves[s.quad].link, s) : next;
  }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View& view, const Ray&, State& state, Hit&, Observer& observer) {
    if (state.is_finished()) return Phase::done;
    observer.backtrack();
    if (state.recent != kNoNode) {
      state.rise_to_postponed(observer);
      return cross_to(state.recent, state, observer);
    }
    if (state.is_postponed(1)) {
      state.rise(1, observer);
      return cross_to(state.uncle, state, observer);
    }
    if (state.is_postponed(2)) {
      state.rise(2, observer);
      return cross_to(state.grand_uncle, state, observer);
    }
    if (state.grand_uncle == kNoNode) return Phase::done;  // halves of a deep path may be without bits
    state.rise(2, observer);
    climb_from(view, state.grand_uncle, state, observer);
    return Phase::backtrack;
  }

 private:
  template <class Observer>
  ACCEL_HD static Phase go_down(const Bvh2Node& node, std::uint32_t side, bool postponed, State& state, Observer& observer) {
    state.step_down(side, postponed, 0, observer);  // only paused traversals read the turns; compilers see that
    return enter_node(state, node.child[side], observer);
  }
  template <class Observer>
  ACCEL_HD static Phase postpone(const Bvh2Node& node, std::uint32_t farther, State& state, Observer& observer) {
    state.recent = node.child[farther];
    return go_down(node, farther ^ 1u, true, state, observer);
  }
  template <class Observer>
  ACCEL_HD static Phase cross_to(NodeRef sibling, State& state, Observer& observer) {
    state.cross();
    state.recent = kNoNode;
    return enter_node(state, sibling, observer);
  }

  // Fills the register from the links of a node that is left behind.
  ACCEL_HD static void recall(const NodeRef* link, State& state) {
    if (state.recent != kNoNode) return;
    if (state.is_postponed(1))
      state.recent = link[0];
    else if (state.is_postponed(2))
      state.recent = link[1];
  }

  ACCEL_HD static Phase leave(const NodeRef* link, State& state) {
    state.uncle = link[0], state.grand_uncle = link[1];
    return Phase::backtrack;
  }

  // Reads the links of a node whose sibling is the ancestor that the path is at: they have the same uncles.
  template <class Observer>
  ACCEL_HD static void climb_from(const View& view, NodeRef node, State& state, Observer& observer) {
    if (is_leaf(node)) {
      const LeafQuad* const quads = view.leaves + leaf_quad(node);
      observer.load(Memory::triangle, &quads[1].word, sizeof quads[1].word);
      observer.load(Memory::triangle, &quads[2].word, sizeof quads[2].word);
      state.uncle = quads[1].word, state.grand_uncle = quads[2].word;
      return;
    }
    const NodeRef* const link = view.nodes[node].link;
    observer.load(Memory::node, link, sizeof view.nodes[node].link);
    state.uncle = link[0], state.grand_uncle = link[1];
  }
};

// The method, for trees of any depth.
template <class Test, Query kQuery>
struct Bvh2Uncle : Bvh2UncleWith<Test, kQuery, DeepPath> {
  using Specialisations =
      TypeList<Bvh2UncleWith<Test, kQuery, NodePath<std::uint32_t>>, Bvh2UncleWith<Test, kQuery, NodePath<std::uint64_t>>>;
};

}  // namespace accel
