// Traversal of a Bvh2 without a stack, by skip pointers: Smits 1998, "Efficiency Issues for Ray Tracing"; with one order of
// children for each octant of ray directions as Boulos and Haines 2006, "Ray-Box Sorting".
//
// The order of children is fixed, so what comes after a subtree is known when the structure is built: every inner node names
// the ancestor whose second child is next (structure/bvh2.h). The state is a node and whether its first child is done.
//
// Deviation: nodes hold the boxes of both children, so a step tests both, and goes on with the second at once where the first
// is missed; the second is tested again, against the hit found in the first, when the traversal comes back to it.
//
// With one order (Bvh2Skip) nodes are visited front to back for half of the directions at best. With eight (Bvh2SkipOctant)
// the order is nearly that of the stack version, for 32 bytes a node; rays of one octant read 4 of them.
#pragma once

#include "libaccel/trace/bvh2_common.h"

namespace accel {

template <class Test, Query kQuery, bool kPerOctant>
struct Bvh2SkipWith {
  static constexpr const char* kName = kPerOctant ? "skip-octant" : "skip";
  using View = Bvh2View;
  static constexpr Bvh2Extras kNeeds = kPerOctant ? Bvh2Extras::octant_skips : Bvh2Extras::skips;

  struct State : Bvh2State<Test> {
    std::uint32_t order;  // where the octant's skip pointers begin
    std::uint32_t next;   // the node whose second child is next; kNoSkip: none
    bool is_second;       // whether that is where the traversal is
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    if (!begin_bvh2(view, ray, state, hit)) return Phase::done;
    const std::uint32_t octant = (ray.dir.x < 0 ? 1u : 0u) | (ray.dir.y < 0 ? 2u : 0u) | (ray.dir.z < 0 ? 4u : 0u);
    state.order = kPerOctant ? octant : 0u;
    state.next = kNoSkip, state.is_second = false;
    return enter_node(state, view.root, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    const Bvh2Node& node = visit_node(view, state.node, observer);
    const std::uint32_t skip = load_skip(view, state, observer), first = first_child(skip);
    const BoxPairHit boxes = state.boxes.intersect(node, hit.t);
    const bool enters_first = !state.is_second && (boxes.mask >> first & 1u) != 0;
    const bool enters_second = (boxes.mask >> (first ^ 1u) & 1u) != 0;
    state.is_second = false;
    if (enters_first) {
      state.next = enters_second ? state.node : skip_target(skip);
      return enter_node(state, node.child[first], observer);
    }
    state.next = skip_target(skip);
    return enters_second ? enter_node(state, node.child[first ^ 1u], observer) : Phase::backtrack;
  }

  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    return intersect_next<Test, kQuery>(view.leaves, ray, s.test, s.boxes.t_min, s.quad, hit, Phase::backtrack, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View&, const Ray&, State& state, Hit&, Observer& observer) {
    if (state.next == kNoSkip) return Phase::done;
    observer.backtrack();
    state.is_second = true;
    return enter_node(state, state.next, observer);
  }

 private:
  template <class Observer>
  ACCEL_HD static std::uint32_t load_skip(const View& view, const State& state, Observer& observer) {
    const std::size_t at = static_cast<std::size_t>(state.order) * view.node_count + state.node;
    const std::uint32_t* const skip = (kPerOctant ? view.octant_skips : view.skips) + at;
    observer.load(Memory::node, skip, sizeof *skip);
    return *skip;
  }
};

template <class Test, Query kQuery>
struct Bvh2Skip : Bvh2SkipWith<Test, kQuery, false> {};

template <class Test, Query kQuery>
struct Bvh2SkipOctant : Bvh2SkipWith<Test, kQuery, true> {};

}  // namespace accel
