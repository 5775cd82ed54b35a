// Traversal of a Bvh2 that is paused at a hit and resumed to the next one: Binder and Keller 2016 [BK16], section 2.4, "Pausing
// and Resuming".
//
// A traversal without a stack is resumed from the key of a node: the node is found in the hash, and a trail of ones below the
// key's leading one has every sibling on the way up to the root visited. Pausable<Base> adds that to a traverser of trace/: to
// bvh2_hash.h, with all keys in the hash or with those that it looks up; bvh2_uncle.h; and bvh2_sibling.h.
//
// What a paused traversal is. PausedTraversal: where the hit was found (key, trail and the leaf itself), and the hit's place in
// the order of hits (trace/multi_hit.h). All else follows from the ray. It has no pointers, and a size that depends on nothing.
// Resuming names the closest hit behind that place, so that all hits come in order, each once, though with spatial splits a
// triangle may be in several leaves, and though the leaves of one ray may overlap.
//
// The trail. [BK16] keeps the bit trail "to avoid revisiting uncles that already have been culled". A postponed node's bit goes
// when the node has been visited, or when a nearer hit drops it, but either may hold the hit after next. So the path that is
// kept has a second trail: which siblings the ray meets at all, from its last hit on, whatever was found in front of them.
// Siblings that the ray misses are never visited, as [BK16] wants. (Testing both boxes up to the ray's end takes no more
// tests.)
//
// Another ray, as in path tracing from the point of the hit: for_another_ray() forgets what was culled.
//
// By the key alone: node and trail may be missing (by_key_alone()). The node is found in constant time where all keys are
// hashed; other traversers go down to it from the root.
//
// What it saves. With random rays a resumed traversal visits 0.43 (colonnade) to 0.76 (soup) of the nodes that a traversal
// behind the same hit visits from the root; by its key alone 0.86 to 0.88. On a CPU both take the same time, as [BK16] found on
// GPUs: the nodes that are saved are those in the caches.
//
// Needs. Trees down to depth 63; check_pausable() tells of deeper ones, and of missing links and tables. A traverser with a
// register for the node postponed last starts with the leaf's sibling in it. No links lead there, and its key need not be in
// the hash if not all are: it is then sought from the root, one load a level and without box tests.
//
// Not over instances, where a place is one path in each of two trees: AnyAccel::next_hits() goes on behind a hit with every
// method, from the root.
//
// Trust. resume() believes what it is given. Bytes from elsewhere pass paused_from_bytes(), which proves them against the tree
// in O(depth).
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "libaccel/core/result.h"
#include "libaccel/trace/bvh2_hash.h"
#include "libaccel/trace/bvh2_sibling.h"
#include "libaccel/trace/bvh2_uncle.h"
#include "libaccel/trace/hash_look_up.h"
#include "libaccel/trace/multi_hit.h"

namespace accel {

struct PausedTraversal {
  std::uint64_t key = 0;            // of the leaf where the hit is; 0: there is none, and no other will come
  std::uint64_t trail = 0;          // bit i: the sibling of the leaf's ancestor i levels up may have hits
  NodeRef node = kNoNode;           // the leaf, or kNoNode: its key will do
  HitPlace after = kBeforeAllHits;  // the hit

  ACCEL_HD bool is_finished() const { return key == 0; }

  // All siblings up to the root.
  ACCEL_HD std::uint64_t whole_trail() const { return (std::uint64_t{1} << (std::bit_width(key) - 1)) - 1; }

  // Where all keys are hashed. Not of a finished traversal.
  ACCEL_HD PausedTraversal by_key_alone() const { return {key, whole_trail(), kNoNode, after}; }

  // From the same leaf on, for a ray with another origin or direction, whose hits all count. Not of a finished traversal.
  ACCEL_HD PausedTraversal for_another_ray() const { return {key, whole_trail(), node, kBeforeAllHits}; }
};
static_assert(sizeof(PausedTraversal) == 32 && std::is_trivially_copyable_v<PausedTraversal>);

// A paused traversal as bytes, little-endian: key, trail (8 each), node, t, prim_id (4 each).
inline constexpr std::size_t kPausedBytes = 28;
std::array<std::byte, kPausedBytes> to_bytes(const PausedTraversal& paused);

// Proves that the bytes are a paused traversal of this tree, or one by its key alone: the key leads to the node, the trail is
// not longer than the path, and t is one that a hit can have. So no traversal leaves the arrays, whatever the bytes are.
// Errors say what is wrong with them.
Result<PausedTraversal> paused_from_bytes(const Bvh2View& view, std::span<const std::byte> bytes);

// The node with a key, by its turns from the root on: O(depth). kNoNode if there is none.
template <class Observer>
ACCEL_HD NodeRef node_at(const Bvh2View& view, std::uint64_t key, Observer& observer) {
  if (key == 0) return kNoNode;
  NodeRef node = view.root;
  for (int turn = std::bit_width(key) - 2; turn >= 0; --turn) {
    if (is_leaf(node)) return kNoNode;  // so is kNoNode
    const NodeRef* const child = view.nodes[node].child + (key >> turn & 1u);
    observer.load(Memory::node, child, sizeof *child);
    node = *child;
  }
  return node;
}

// A path that knows, beyond what is postponed, which siblings the ray meets.
struct PausablePath : NodePath<std::uint64_t> {
  std::uint64_t met;  // bit i: the ray meets the sibling of the ancestor i levels up
  bool meets_both;    // children of the node that it is in: see test_boxes()
  float t_end;        // of the ray

  ACCEL_HD void begin() {
    NodePath::begin();
    met = 0;
  }
  template <class Observer>
  ACCEL_HD void step_down(std::uint32_t side, bool postponed, std::uint64_t multiplier, Observer& observer) {
    NodePath::step_down(side, postponed, multiplier, observer);
    met = met << 1 | (meets_both ? 1u : 0u);
  }
  template <class Observer>
  ACCEL_HD void rise(int levels, Observer& observer) {
    NodePath::rise(levels, observer);
    met >>= levels;
  }
  template <class Observer>
  ACCEL_HD bool rise_to_postponed(Observer& observer) {
    if (trail == 0) return false;
    rise(trailing_zeros(trail), observer);
    return true;
  }
};

// Base is a traverser of closest hits with the test After<...> and the path PausablePath.
template <class Base>
struct Pausable : Base {
  using View = Bvh2View;

  struct State : Base::State {
    PausedTraversal paused;  // at the hit so far
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    const Phase phase = Base::begin(view, ray, state, hit, observer);
    state.t_end = hit.t;
    state.paused = PausedTraversal{};
    return phase;
  }

  // Instead of begin(). `paused` is of a traversal of this tree; `ray` is its ray, or another one for one that is for another
  // ray. The hit will be the closest one behind the one where it was paused.
  template <class Observer>
  ACCEL_HD static Phase resume(const View& view, const Ray& ray, const PausedTraversal& paused, State& state, Hit& hit,
                               Observer& observer) {
    const Ray rest = behind(ray, paused.after);
    const Phase phase = begin(view, rest, state, hit, observer);
    if (phase == Phase::done || paused.is_finished()) return Phase::done;
    state.test.after = paused.after;
    state.key = paused.key, state.trail = state.met = paused.trail;
    if constexpr (kHasRegister)
      if (state.is_postponed(0)) state.recent = node_at(view, paused.key ^ 1u, observer);
    return enter_node(state, paused.node != kNoNode ? paused.node : find_node(view, state, observer), observer);
  }

  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    const HitPlace before = place_of(hit);
    const Phase phase = Base::intersect(view, ray, state, hit, observer);
    if (is_before(place_of(hit), before)) state.paused = {state.key, state.met, state.node, place_of(hit)};
    return phase;
  }

 private:
  static constexpr bool kLooksUpAll = requires { requires Base::kLooksUpAll; };
  static constexpr bool kHasRegister = !kLooksUpAll && requires(State & state) { state.recent; };

  // The node with the state's key.
  template <class Observer>
  ACCEL_HD static NodeRef find_node(const View& view, const State& state, Observer& observer) {
    if constexpr (kLooksUpAll)
      if (state.key != 1) return look_up(view, state.hashed_key(), observer);
    return node_at(view, state.key, observer);
  }
};

template <class Test>
using PausableHash = Pausable<Bvh2HashWith<After<Test>, Query::closest, PausablePath>>;
template <class Test>  // with all keys hashed
using PausableFullHash = Pausable<Bvh2HashWith<After<Test>, Query::closest, PausablePath, Bvh2HashOptions<false>>>;
template <class Test>
using PausableUncle = Pausable<Bvh2UncleWith<After<Test>, Query::closest, PausablePath>>;
template <class Test>
using PausableSibling = Pausable<Bvh2SiblingWith<After<Test>, Query::closest, PausablePath>>;

// Whether a tree has what pausable traversers with these needs read. Errors name what is missing.
Status check_pausable(const Bvh2& bvh, std::span<const Bvh2Extras> needs);

template <class Traverser>
Status check_pausable(const Bvh2& bvh) {
  if constexpr (std::is_array_v<decltype(Traverser::kNeeds)>)
    return check_pausable(bvh, Traverser::kNeeds);
  else
    return check_pausable(bvh, std::span(&Traverser::kNeeds, 1));
}

}  // namespace accel
