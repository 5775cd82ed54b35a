// Traversal of a Bvh2 without a stack, by restarts from the root: Laine 2010, "Restart Trail for Stackless BVH Traversal"; with
// a short stack as Horn et al. 2007 as an option.
//
// The trail has a bit for each level, the first for the root's children. Where the ray enters both children, 0 says that the
// nearer is being visited and 1 that the farther is; where it enters one, the bit is 1. So to go back is to add 1 at the
// current level: the carry clears the levels that are done and stops at the last level where the farther child is left. Then
// the traversal restarts from the root, lets the bits choose between children, and arrives at that farther child.
//
// The short stack keeps the last few postponed nodes, with their distances, and saves the restarts that end at one of them.
//
// Trees deeper than 63 are traversed in segments: the trail of the levels above is put aside, and restarts begin at the
// segment's root.
//
// What is visited. On the way down from a restart, nodes above the target are visited again; otherwise the nodes are those of
// the stack version, and so are the leaves, in the same order. One exception: a hit that rounding has moved nearer than its box
// (box_pair.h) may hide the farther child on the way to what is left in it, and the nearer child is then visited twice. Hits
// do not change.
#pragma once

#include "libaccel/trace/bvh2_common.h"
#include "libaccel/trace/traverser.h"

namespace accel {

// What is addressed at run time: see trace/traverser.h.
template <bool kDeep, std::uint32_t kShortStackSize>
struct RestartTrailStack {
  struct Segment {
    std::uint64_t trail;
    NodeRef root;
  };
  struct Postponed {
    NodeRef node;
    float t_near;
  };
  static constexpr std::uint32_t kMaxSegments = kDeep ? 16 : 1;

  Segment segments[kMaxSegments];                                  // put aside
  Postponed postponed[kShortStackSize > 0 ? kShortStackSize : 1];  // a ring
};

template <bool kDeep, std::uint32_t kShortStackSize>
struct RestartTrailTraits {
  using Stack = RestartTrailStack<kDeep, kShortStackSize>;
  static constexpr std::uint32_t kMaxDepth = kMaxDepth64 * (1 + (kDeep ? Stack::kMaxSegments : 0));
  struct StackPointer {
    Stack* stack;
  };
};
template <>
struct RestartTrailTraits<false, 0> {
  static constexpr std::uint32_t kMaxDepth = kMaxDepth64;
  struct StackPointer {};
};

// kShortStackSize: entries; 0 or a power of two.
template <class Test, Query kQuery, bool kDeep, std::uint32_t kShortStackSize>
struct Bvh2RestartTrailWith : RestartTrailTraits<kDeep, kShortStackSize> {
  static constexpr const char* kName = "restart-trail";
  using View = Bvh2View;
  using Traits = RestartTrailTraits<kDeep, kShortStackSize>;
  static constexpr bool kShort = kShortStackSize > 0;

  struct State : Bvh2State<Test>, Traits::StackPointer {
    std::uint64_t trail;
    std::uint64_t level;      // of the node, as a bit; of the root, kRootLevel
    std::uint64_t pop_level;  // of the node for which the traversal has restarted
    NodeRef root;             // where restarts begin
    std::uint32_t segments;   // that are put aside
    std::uint32_t top, size;  // of the short stack
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    if (!begin_bvh2(view, ray, state, hit)) return Phase::done;
    state.segments = state.top = state.size = 0;
    begin_segment(view.root, state);
    return enter_node(state, view.root, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    if (kDeep && state.level == 1) put_aside(state, observer);
    const Bvh2Node& node = visit_node(view, state.node, observer);
    const BoxPairHit boxes = state.boxes.intersect(node, hit.t);
    if (boxes.mask == 0) return Phase::backtrack;
    const std::uint64_t level = state.level >> 1;
    if (boxes.mask != 3) {
      if (level == state.pop_level) return Phase::backtrack;  // the farther child has been culled since it was postponed
      state.trail |= level, state.level = level;
      return enter_node(state, node.child[boxes.mask >> 1], observer);
    }
    state.level = level;
    const std::uint32_t near = nearer_child(boxes);
    if ((state.trail & level) != 0) return enter_node(state, node.child[near ^ 1u], observer);
    if constexpr (kShort) push(node.child[near ^ 1u], near == 0 ? boxes.t_near1 : boxes.t_near0, state, observer);
    return enter_node(state, node.child[near], observer);
  }

  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    return intersect_next<Test, kQuery>(view.leaves, ray, s.test, s.boxes.t_min, s.quad, hit, Phase::backtrack, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View&, const Ray&, State& state, [[maybe_unused]] Hit& hit, Observer& observer) {
    state.trail &= ~state.level + 1;  // the levels below are done
    state.trail += state.level;
    if ((state.trail & kRootLevel) != 0) return end_segment(state, observer);
    observer.backtrack();
    state.pop_level = state.trail & (~state.trail + 1);
    if constexpr (kShort)
      if (state.size > 0) return pop(state, hit, observer);
    state.level = kRootLevel;
    return enter_node(state, state.root, observer);
  }

 private:
  static constexpr std::uint64_t kRootLevel = std::uint64_t{1} << kMaxDepth64;

  ACCEL_HD static void begin_segment(NodeRef root, State& state) {
    state.root = root;
    state.trail = 0, state.level = kRootLevel, state.pop_level = 0;
  }

  // The levels are used up: the node becomes the root of a segment.
  template <class Observer>
  ACCEL_HD static void put_aside(State& state, Observer& observer) {
    if constexpr (kDeep) {
      ACCEL_ASSERT(state.segments < Traits::Stack::kMaxSegments);
      auto& segment = state.stack->segments[state.segments++];
      observer.store(Memory::stack, &segment, sizeof segment);
      segment = {state.trail, state.root};
      begin_segment(state.node, state);
    }
  }
  // Back to the segment above, where the node that was this one's root is done.
  template <class Observer>
  ACCEL_HD static Phase end_segment(State& state, Observer& observer) {
    if constexpr (kDeep) {
      if (state.segments > 0) {
        const auto& segment = state.stack->segments[--state.segments];
        observer.load(Memory::stack, &segment, sizeof segment);
        state.trail = segment.trail, state.root = segment.root, state.level = 1;
        return Phase::backtrack;
      }
    }
    return Phase::done;
  }

  template <class Observer>
  ACCEL_HD static void push(NodeRef node, float t_near, State& state, Observer& observer) {
    auto& entry = state.stack->postponed[state.top++ % kShortStackSize];
    observer.store(Memory::stack, &entry, sizeof entry);
    entry = {node, t_near};
    if (state.size < kShortStackSize) ++state.size;
  }
  template <class Observer>
  ACCEL_HD static Phase pop(State& state, const Hit& hit, Observer& observer) {
    const auto& entry = state.stack->postponed[--state.top % kShortStackSize];
    observer.load(Memory::stack, &entry, sizeof entry);
    --state.size;
    state.level = state.pop_level;
    return entry.t_near <= hit.t * kFarScale ? enter_node(state, entry.node, observer) : Phase::backtrack;
  }
};

// The method, for trees of any depth.
template <class Test, Query kQuery>
struct Bvh2RestartTrail : Bvh2RestartTrailWith<Test, kQuery, true, 0> {
  using Specialisations = TypeList<Bvh2RestartTrailWith<Test, kQuery, false, 0>>;
};

}  // namespace accel
