// What a traverser is, and what an implementer supplies.
//
// A traverser is a small state machine over one ray: a class template
//
//   template <class Test, Query kQuery> struct MyTraverser {
//     static constexpr const char* kName;  // the second half of a method's name: "stack" in "bvh/stack"
//     using View = ...;     // the non-owning view of its structure, passed by value: Structure::View
//     struct State {...};   // trivially copyable, of constant size: copying it pauses the traversal
//     struct Stack {...};   // optional, likewise: arrays with run-time indices; State has a member Stack* stack (see below)
//     static constexpr std::uint32_t kMaxDepth = ...;  // optional: the deepest tree that the state has room for
//     static constexpr SkippedFeature kSkips = ...;    // optional: what users may expect of it, and why it does without
//     static constexpr bool kIsExhaustive = true;      // optional: every ray tests every triangle
//     static constexpr bool kIsRobust = false;         // optional: it is known to lose hits, whatever the triangle test
//     template <class Observer> ACCEL_HD static Phase begin    (const View&, const Ray&, State&, Hit&, Observer&);
//     template <class Observer> ACCEL_HD static Phase descend  (const View&, const Ray&, State&, Hit&, Observer&);
//     template <class Observer> ACCEL_HD static Phase intersect(const View&, const Ray&, State&, Hit&, Observer&);
//     template <class Observer> ACCEL_HD static Phase backtrack(const View&, const Ray&, State&, Hit&, Observer&);
//   };
//
// Each function does one step and returns the phase that comes next: descend, one inner node; intersect, one primitive of a
// leaf; backtrack, one step towards the next postponed node. begin() prepares the state and the hit. Test is a triangle test of
// geometry/, kQuery says whether the first hit will do. Who drives the machine, and in which order over many rays, is none of
// its business: see exec/.
//
// Observers. A step tells its observer what it loads and stores, and what it does: as NullObserver lists them.
//
// Tests that keep what they find. Multi-hit queries use any traverser, with triangle tests whose data tell where found hits go
// (trace/multi_hit.h). So what Test::prepare() made is a member `test` of the state, begin() tests no triangle, and what is
// culled is what hit.t allows.
//
// Stacks. Compilers for devices (LLVM's) keep an object in registers only if nothing in it is addressed at run time, so a stack
// inside the state would drag the ray's whole state into memory. A traverser with a stack declares it as a type of its own; the
// driver provides one (StackOf), lets the state point to it before begin() (attach_stack), and copies both to pause a ray.
//
// Speculation. A driver may postpone the test of a leaf and let the ray go on in the meantime (Aila and Laine 2009,
// section 3.2), if what comes after a leaf does not depend on the hits in it, and if the traverser says how
// (SpeculativeTraverser):
//
//     ACCEL_HD static std::uint32_t& leaf(State&);  // names the triangle that intersect() tests next; nothing else that
//                                                   // intersect() reads changes while the ray goes on
//     static constexpr Phase kAfterLeaf = ...;      // what intersect() returns when the leaf has ended
//
// Specialisations. A traverser that serves trees of any depth may have others that do the same in shallow ones with less state
// (SpecialisedTraverser). It lists them, the shallowest first; executors choose once a batch, by with_traverser():
//
//     using Specialisations = TypeList<...>;       // traversers, each with its kMaxDepth; View has the tree's depth
//     static constexpr bool kForDevices = true;    // optional, of a specialisation: what it saves is nothing on a CPU
//
// During traversal hit.t is the end of the interval that is still of interest; begin_hit() and accept_hit() keep the rules that
// all traversers share, so that all of them name the same triangle. finish_hit() turns the state into an answer.
#pragma once

#include <concepts>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/core/type_list.h"

namespace accel {

struct SkippedFeature {
  const char* what;
  const char* why;
};

enum class Phase : std::uint8_t { descend, intersect, backtrack, done };

template <class Traverser>
concept StackTraverser = requires(typename Traverser::State& state, typename Traverser::Stack& stack) {
  state.stack = &stack;
};

namespace detail {
struct NoStack {};
template <class Traverser>
struct StackType {
  using type = NoStack;
};
template <StackTraverser Traverser>
struct StackType<Traverser> {
  using type = typename Traverser::Stack;
};
}  // namespace detail

// The stack that a driver provides for a ray: empty where the traverser needs none.
template <class Traverser>
using StackOf = typename detail::StackType<Traverser>::type;

template <class Traverser>
ACCEL_HD void attach_stack(typename Traverser::State& state, StackOf<Traverser>& stack) {
  if constexpr (StackTraverser<Traverser>) state.stack = &stack;
}

template <class Traverser>
concept SpeculativeTraverser = requires(typename Traverser::State& state) {
  { Traverser::leaf(state) } -> std::same_as<std::uint32_t&>;
  { Traverser::kAfterLeaf } -> std::convertible_to<Phase>;
};

template <class Traverser>
concept SpecialisedTraverser = requires {
  Traverser::Specialisations::size;
};

enum class Machine : std::uint8_t { cpu, device };

namespace detail {

template <class Traverser, Machine kMachine>
constexpr bool pays_on() {
  if constexpr (requires { Traverser::kForDevices; })
    return kMachine == Machine::device || !Traverser::kForDevices;
  else
    return true;
}

template <class Traverser, Machine kMachine, class Visit>
decltype(auto) visit_first_deep_enough(TypeList<>, std::uint32_t, Visit& visit) {
  return visit(std::type_identity<Traverser>{});
}
template <class Traverser, Machine kMachine, class First, class... Rest, class Visit>
decltype(auto) visit_first_deep_enough(TypeList<First, Rest...>, std::uint32_t depth, Visit& visit) {
  if constexpr (pays_on<First, kMachine>())
    if (depth <= First::kMaxDepth) return visit(std::type_identity<First>{});
  return visit_first_deep_enough<Traverser, kMachine>(TypeList<Rest...>{}, depth, visit);
}

}  // namespace detail

// visit(std::type_identity<T>{}) with the traverser that serves this structure best.
template <class Traverser, Machine kMachine = Machine::cpu, class Visit>
decltype(auto) with_traverser(const typename Traverser::View& view, Visit&& visit) {
  if constexpr (SpecialisedTraverser<Traverser>)
    return detail::visit_first_deep_enough<Traverser, kMachine>(typename Traverser::Specialisations{}, view.depth, visit);
  else
    return visit(std::type_identity<Traverser>{});
}

// What a load or store of a traverser touches. The SIMT model reports bytes by these classes.
enum class Memory : std::uint8_t { node, triangle, stack, hash, ray };
inline constexpr int kMemoryClasses = 5;

// Sees what a traverser does. This one sees nothing and compiles to nothing.
struct NullObserver {
  ACCEL_HD void load(Memory, const void*, std::uint32_t) {}
  ACCEL_HD void store(Memory, const void*, std::uint32_t) {}
  ACCEL_HD void node_step() {}                // an inner node has been visited on the way down
  ACCEL_HD void leaf_visit(std::uint32_t) {}  // a leaf has been reached, an empty one too; its name in the structure
  ACCEL_HD void box_tests(std::uint32_t) {}   // so many boxes have been tested
  ACCEL_HD void triangle_test() {}
  ACCEL_HD void backtrack() {}  // a step towards the next postponed node
};

// Starts a query: the interval is the ray's, clipped to [0, largest float].
ACCEL_HD void begin_hit(const Ray& ray, Hit& hit) {
  hit.t = min_of(ray.t_max, std::numeric_limits<float>::max());
  hit.u = hit.v = 0.0f;
  hit.prim_id = kNoHit;
}

// The start of the ray's interval: rays do not reach behind their origin.
ACCEL_HD float first_t(const Ray& ray) { return max_of(ray.t_min, 0.0f); }

// Takes a candidate when it lies in the interval that is left (both ends belong to it) and is nearer than the hit so far, or as
// near with a lower prim_id. A candidate whose t is NaN or infinite is refused.
ACCEL_HD bool accept_hit(const Hit& candidate, float t_min, Hit& hit) {
  if (!(candidate.t >= t_min)) return false;
  if (!(candidate.t < hit.t || (candidate.t == hit.t && candidate.prim_id < hit.prim_id))) return false;
  hit = candidate;
  return true;
}

// Ends a query: a miss gets the values that Hit documents.
ACCEL_HD void finish_hit(Hit& hit) {
  if (!hit.valid()) hit = Hit{};
}

// The answer of a batch to a ray: its hit, or 1 where an any-hit query has met something, else 0.
ACCEL_HD void store_answer(const Hit& hit, Hit& answer) { answer = hit; }
ACCEL_HD void store_answer(const Hit& hit, std::uint8_t& answer) { answer = hit.valid() ? 1 : 0; }

}  // namespace accel
