// Traversal of a Bvh2 without a stack, with backtracking in constant time: Binder and Keller 2016, "Efficient Stackless
// Hierarchy Traversal on GPUs with Backtracking in Constant Time" [BK16], Algorithm 1. (US patent 10,706,608 describes
// backtracking by such a hash.)
//
// The order is that of the stack version (bvh2_stack.h). In place of a stack the state has a bit trail, which says on which
// levels a sibling was postponed, the key of the current node, and a register for the most recently postponed node. Where the
// register is empty it is filled from the links that come with each node, uncle and grand-uncle, or with the end of a leaf,
// which has the great-grand-uncle too. If it is still empty when the traversal has to go back, the key of the target, one shift
// away, is looked up in a perfect hash (structure/node_hash.h). structure/bvh2.h says which keys that may be.
//
// Deviations. [BK16] tests two bits at leaves, here three. Links are looked at after the boxes, and only where the register is
// not overwritten anyway. [BK16]'s mask of disjoint t-intervals is an option, made safe: it drops postponed siblings that lie
// behind the nearer child's interval once a hit has been found, but with spatial splits a hit may lie beyond the nearer child's
// box, even behind the sibling's entry. So the least entry distance of all siblings that may be dropped is kept, and none is
// dropped unless the hit is nearer than that.
//
// What is visited. Postponed nodes have no distance stored, so they are entered even if a nearer hit was found meanwhile; their
// children are culled at once. So the nodes visited are those of the stack version without its test of postponed nodes, in the
// same order. An addition to [BK16]: the node in the register keeps its distance there, and is dropped as the stack version
// drops it; with the mask, some others are too. Hits are the same.
//
// More registers. On CPUs the method remembers four nodes in place of one (bvh2_hash_recent.h), in trees down to depth 63.
//
// The state has constant size. A copy of it, taken between two steps, resumes where it was taken (see also DeepPath::Stack).
#pragma once

#include <limits>

#include "libaccel/trace/bvh2_common.h"
#include "libaccel/trace/bvh2_hash_recent.h"
#include "libaccel/trace/hash_look_up.h"
#include "libaccel/trace/node_path.h"

namespace accel {

template <bool kUseRegister = true, bool kUseMask = false, bool kUseDistance = true>
struct Bvh2HashOptions {
  static constexpr bool kRegister = kUseRegister;  // off: every target is looked up, so all keys must be hashed
  static constexpr bool kMask = kUseMask;          // in trees down to depth 63
  static constexpr bool kDistance = kUseDistance;  // off: no postponed node is ever dropped
};

// Which of the siblings on the trail are disjoint from the node that came first, and the least t at which one is entered.
template <class Word>
struct DisjointTrail {
  Word overlapping;
  float nearest;

  ACCEL_HD void begin() { overlapping = 0, nearest = std::numeric_limits<float>::infinity(); }
  ACCEL_HD void step_down(bool disjoint, float t_near) {
    overlapping = static_cast<Word>(overlapping << 1 | (disjoint ? 0u : 1u));
    if (disjoint && t_near < nearest) nearest = t_near;
  }
  ACCEL_HD void rise(int levels) { overlapping >>= levels; }
};
struct NoDisjointTrail {};

template <class Test, Query kQuery, class Path, class Options = Bvh2HashOptions<>>
struct Bvh2HashWith : Path::Traits {
  static constexpr const char* kName = "hash";
  using View = Bvh2View;
  static constexpr Bvh2Extras kNeeds[] = {Bvh2Extras::uncles, Options::kRegister ? Bvh2Extras::hash : Bvh2Extras::full_hash};
  static constexpr bool kLooksUpAll = !Options::kRegister;
  static constexpr bool kMask = Options::kMask && kQuery == Query::closest;
  static constexpr bool kDistance = Options::kDistance && Options::kRegister && kQuery == Query::closest;

  struct State : Bvh2State<Test>, Path {
    NodeRef recent;     // the most recently postponed node, or kNoNode
    float recent_near;  // where the ray enters it, or 0
    [[no_unique_address]] std::conditional_t<kMask, DisjointTrail<typename Path::Word>, NoDisjointTrail> disjoint;
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    if (!begin_bvh2(view, ray, state, hit)) return Phase::done;
    state.Path::begin();
    state.recent = kNoNode, state.recent_near = 0;
    if constexpr (kMask) state.disjoint.begin();
    return enter_node(state, view.root, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    const Bvh2Node& node = visit_node(view, state.node, observer);
    const BoxPairHit boxes = test_boxes(state, node, hit.t);
    // Branches, not selects: see bvh2_stack.h.
    if (boxes.mask == 3) {
      if (boxes.t_near1 < boxes.t_near0) return postpone(view, node, 0, boxes, state, observer);
      return postpone(view, node, 1, boxes, state, observer);
    }
    recall(state, node.link);
    if (boxes.mask == 0) return Phase::backtrack;
    if (boxes.mask == 1) return go_down(view, node, 0, false, state, observer);
    return go_down(view, node, 1, false, state, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    const Phase next =
        intersect_next<Test, kQuery>(view.leaves, ray, s.test, s.boxes.t_min, s.quad, hit, Phase::backtrack, observer);
    return next == Phase::backtrack ? end_leaf(view, s, hit) : next;
  }

  // Of the state in a leaf; what both are for: see trace/two_level.h.
  ACCEL_HD static std::uint32_t& leaf(State& state) { return state.quad; }
  ACCEL_HD static Phase end_leaf(const View& view, State& s, const Hit& hit) {
    if constexpr (kMask) drop_disjoint(s, hit);  // before the register is filled, which the links here are for
    if constexpr (kDistance) drop_recent(s, hit);
    recall_in_leaf(s, view.leaves[s.quad].link);
    return Phase::backtrack;
  }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View& view, const Ray&, State& state, Hit&, Observer& observer) {
    if constexpr (kMask) state.disjoint.rise(state.trail == 0 ? 0 : trailing_zeros(state.trail));
    if (!state.rise_to_postponed(observer)) return Phase::done;
    observer.backtrack();
    state.cross();
    const NodeRef target = state.recent != kNoNode ? state.recent : look_up(view, state.hashed_key(), observer);
    state.recent = kNoNode;
    return enter_node(state, target, observer);
  }

 protected:
  template <class Observer>
  ACCEL_HD static Phase go_down(const View& view, const Bvh2Node& node, std::uint32_t side, bool postponed, State& state,
                                Observer& observer) {
    state.step_down(side, postponed, view.hash.multiplier, observer);
    if constexpr (kMask)
      if (!postponed) state.disjoint.step_down(false, 0);
    return enter_node(state, node.child[side], observer);
  }

  // Goes to the nearer child; `farther` is the other.
  template <class Observer>
  ACCEL_HD static Phase postpone(const View& view, const Bvh2Node& node, std::uint32_t farther, const BoxPairHit& boxes,
                                 State& state, Observer& observer) {
    if constexpr (Options::kRegister) state.recent = node.child[farther];
    if constexpr (kDistance) state.recent_near = farther == 0 ? boxes.t_near0 : boxes.t_near1;
    if constexpr (kMask) {
      const float leave = farther == 0 ? boxes.t_far1 : boxes.t_far0, enter = farther == 0 ? boxes.t_near0 : boxes.t_near1;
      state.disjoint.step_down(leave * kFarScale < enter, enter);
    }
    return go_down(view, node, farther ^ 1u, true, state, observer);
  }

  // Fills the register from the links of a node that is left behind.
  ACCEL_HD static void recall(State& state, const NodeRef* link) {
    if (!Options::kRegister || state.recent != kNoNode) return;
    if (state.is_postponed(1))
      set_recent(state, link[0]);
    else if (state.is_postponed(2))
      set_recent(state, link[1]);
  }
  ACCEL_HD static void recall_in_leaf(State& state, const NodeRef* link) {
    if (!Options::kRegister || state.recent != kNoNode) return;
    recall(state, link);
    if (state.recent == kNoNode && state.is_postponed(3)) set_recent(state, link[2]);
  }
  ACCEL_HD static void set_recent(State& state, NodeRef node) {
    state.recent = node;
    if constexpr (kDistance) state.recent_near = 0;
  }

  // Forgets the node in the register if it is entered behind the hit.
  ACCEL_HD static void drop_recent(State& state, const Hit& hit) {
    if (state.recent == kNoNode || state.recent_near <= hit.t * kFarScale || !state.drop_postponed()) return;
    state.recent = kNoNode;
  }

  // Takes siblings off the trail that are entered behind the hit.
  ACCEL_HD static void drop_disjoint(State& state, const Hit& hit) {
    if (state.disjoint.nearest <= hit.t * kFarScale) return;
    const auto lowest = static_cast<decltype(state.trail)>(state.trail & -state.trail);
    state.trail &= state.disjoint.overlapping;
    if ((lowest & state.trail) == 0) state.recent = kNoNode;
    state.disjoint.nearest = std::numeric_limits<float>::infinity();
  }
};

namespace detail {
template <class Test, Query kQuery>
struct Bvh2HashOfDevices : Bvh2HashWith<Test, kQuery, NodePath<std::uint64_t>> {
  static constexpr bool kForDevices = true;
};
}  // namespace detail

// How many postponed nodes CPUs remember: see bvh2_hash_recent.h.
inline constexpr std::uint32_t kRecentNodes = 4;

// The method, for trees of any depth: with one register on devices and in trees deeper than 63.
template <class Test, Query kQuery>
struct Bvh2Hash : Bvh2HashWith<Test, kQuery, DeepPath> {
  using Specialisations =
      TypeList<Bvh2HashWith<Test, kQuery, NodePath<std::uint32_t>>, Bvh2HashRecentWith<Test, kQuery, PackedPath, kRecentNodes>,
               detail::Bvh2HashOfDevices<Test, kQuery>,
               Bvh2HashRecentWith<Test, kQuery, NodePath<std::uint64_t>, kRecentNodes>>;
};

}  // namespace accel
