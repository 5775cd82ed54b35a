// Traversal of a Bvh2 with backtracking in constant time (bvh2_hash.h), with room for a few of the most recently postponed
// nodes in place of one: the traverser of `hash` on CPUs.
//
// Binder and Keller 2016 [BK16] keep one node in a register. Here the last kCount of them are in a ring, with the distances at
// which the ray enters them: a postponed node overwrites the oldest one. Going back takes the newest from the ring, and drops
// it unread if a nearer hit has been found. Where the ring is empty, the target is the uncle, grand-uncle or, from a leaf,
// great-grand-uncle of the node that is left, or else it is looked up in the perfect hash. So links are read only then, whereas
// [BK16] reads them in every node on the way down as long as its register is empty.
//
// What it is worth. Averaged over the seven scenes of bench/paper_tables bk16: going back loads a word of the tables in one of
// 10 to 15 cases with four nodes, in every other with one register; and of the 2.5 to 5 % more nodes that one register visits
// than a stack does, 0.5 to 1 % are left. On a CPU that saves the latency of the tables, which nothing hides: the address of
// the next node depends on them. With eight nodes the tables are read once in a thousand cases: that is a short stack (Laine
// 2010; bvh2_restart_trail.h) with the hash to fall back on, and another 1 % faster. On devices a ring would be memory
// addressed at run time, where one register is none: they keep to bvh2_hash.h, and so do trees deeper than 63.
//
// Keys. None is looked up that bvh2_hash.h might not look up (HashedKeys in structure/bvh2.h): the sibling of the node that is
// left is in the ring if it is postponed, since nothing was postponed after it, and nodes nearer than those in the hash are
// named by links. Dropping nodes from the ring changes the trail only, not where the path is.
//
// The state has constant size; the ring, an array with run-time indices, lies in what drivers call the stack
// (trace/traverser.h: inside of the state, GCC 12 keeps that in memory and clears it for every ray, which costs more than the
// ring saves). Copies of both resume where they were taken. Trees down to the depth of the path, which is not DeepPath: it
// cannot drop postponed nodes in memory.
#pragma once

#include <bit>
#include <cstdint>

#include "libaccel/trace/bvh2_common.h"
#include "libaccel/trace/hash_look_up.h"
#include "libaccel/trace/node_path.h"

namespace accel {

template <class Test, Query kQuery, class Path, std::uint32_t kCount>
struct Bvh2HashRecentWith : Path::Traits {
  static_assert(std::has_single_bit(kCount));
  static constexpr const char* kName = "hash";
  using View = Bvh2View;
  static constexpr Bvh2Extras kNeeds[] = {Bvh2Extras::uncles, Bvh2Extras::hash};

  struct Postponed {
    NodeRef node;
    float t_near;
  };
  struct Stack {
    Postponed ring[kCount];

    ACCEL_HD Postponed& operator[](std::uint32_t i) { return ring[i % kCount]; }
  };
  struct State : Bvh2State<Test>, Path {
    std::uint32_t next;   // place in the ring for the next one, modulo kCount
    std::uint32_t count;  // how many of those before it are postponed still
    Stack* stack;
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    if (!begin_bvh2(view, ray, state, hit)) return Phase::done;
    state.Path::begin();
    state.next = state.count = 0;
    return enter_node(state, view.root, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    const Bvh2Node& node = visit_node(view, state.node, observer);
    const BoxPairHit boxes = test_boxes(state, node, hit.t);
    // Branches, not selects: see bvh2_stack.h. Two from one child first: that order is the fastest.
    if (boxes.mask == 0) return Phase::backtrack;
    if (boxes.mask != 3) {
      if (boxes.mask == 1) return go_down(view, node, 0, false, state, observer);
      return go_down(view, node, 1, false, state, observer);
    }
    if (boxes.t_near1 < boxes.t_near0) {
      postpone(node.child[0], boxes.t_near0, state, observer);
      return go_down(view, node, 1, true, state, observer);
    }
    postpone(node.child[1], boxes.t_near1, state, observer);
    return go_down(view, node, 0, true, state, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    return intersect_next<Test, kQuery>(view.leaves, ray, s.test, s.boxes.t_min, s.quad, hit, Phase::backtrack, observer);
  }

  // Of the state in a leaf; what both are for: see trace/two_level.h.
  ACCEL_HD static std::uint32_t& leaf(State& state) { return state.quad; }
  ACCEL_HD static Phase end_leaf(const View&, State&, const Hit&) { return Phase::backtrack; }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    while (state.count != 0) {
      observer.backtrack();
      const Postponed& recent = (*state.stack)[--state.next];
      --state.count;
      observer.load(Memory::stack, &recent, sizeof recent);
      if (kQuery == Query::any || recent.t_near <= hit.t * kFarScale) return cross_to(recent.node, state, observer);
      state.drop_postponed();
    }
    return backtrack_far(view, state, observer);
  }

 private:
  template <class Observer>
  ACCEL_HD static Phase go_down(const View& view, const Bvh2Node& node, std::uint32_t side, bool postponed, State& state,
                                Observer& observer) {
    state.step_down(side, postponed, view.hash.multiplier, observer);
    return enter_node(state, node.child[side], observer);
  }

  template <class Observer>
  ACCEL_HD static void postpone(NodeRef node, float t_near, State& state, Observer& observer) {
    Postponed& entry = (*state.stack)[state.next++];
    state.count = state.count < kCount ? state.count + 1 : kCount;
    entry = {node, t_near};
    observer.store(Memory::stack, &entry, sizeof entry);
  }

  template <class Observer>
  ACCEL_HD static Phase cross_to(NodeRef sibling, State& state, Observer& observer) {
    state.rise_to_postponed(observer);
    state.cross();
    return enter_node(state, sibling, observer);
  }

  // To a node that the ring has lost.
  template <class Observer>
  ACCEL_HD static Phase backtrack_far(const View& view, State& state, Observer& observer) {
    if (state.is_finished()) return Phase::done;
    observer.backtrack();
    const NodeRef linked = linked_target(view, state);
    state.rise_to_postponed(observer);
    state.cross();
    return enter_node(state, linked != kNoNode ? linked : look_up(view, state.hashed_key(), observer), observer);
  }

  // The target, if it is among the links of the node that is left.
  ACCEL_HD static NodeRef linked_target(const View& view, const State& state) {
    const bool in_leaf = is_leaf(state.node);
    const NodeRef* const link = in_leaf ? view.leaves[state.quad].link : view.nodes[state.node].link;
    if (state.is_postponed(1)) return link[0];
    if (state.is_postponed(2)) return link[1];
    return in_leaf && state.is_postponed(3) ? link[2] : kNoNode;
  }
};

}  // namespace accel
