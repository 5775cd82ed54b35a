#include "libaccel/exec/any_traverser.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

namespace accel {
namespace {

// Writes down which of its functions was called, with what its state holds. A view is what each of its steps loads and stores.
struct Recorded {
  struct View {
    std::uint32_t loaded, stored;
  };
  struct Stack {
    double entries[3];
  };
  struct State {
    Stack* stack;
    std::uint32_t leaf;
  };
  static constexpr Phase kAfterLeaf = Phase::backtrack;
  static std::uint32_t& leaf(State& state) { return state.leaf; }

  template <class Observer>
  static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    begin_hit(ray, hit);
    state.leaf = 1;
    state.stack->entries[2] = 0.5;
    observer.store(Memory::stack, &state.stack->entries[2], view.stored);
    return Phase::descend;
  }
  template <class Observer>
  static Phase descend(const View& view, const Ray&, State& state, Hit&, Observer& observer) {
    state.leaf *= 10;
    observer.load(Memory::node, &view, view.loaded);
    observer.node_step(), observer.box_tests(2), observer.leaf_visit(7);
    return Phase::intersect;
  }
  template <class Observer>
  static Phase intersect(const View&, const Ray&, State& state, Hit& hit, Observer& observer) {
    state.leaf += 2;
    hit.prim_id = 9;
    observer.triangle_test();
    return Phase::backtrack;
  }
  template <class Observer>
  static Phase backtrack(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    hit.t = static_cast<float>(state.stack->entries[2]);
    observer.load(Memory::stack, &state.stack->entries[2], view.loaded);
    observer.backtrack();
    return Phase::done;
  }
};

// One that says nothing of leaves, and has no stack.
struct Plain {
  using View = int;
  struct State {
    int steps;
  };
  template <class Observer>
  static Phase begin(int, const Ray&, State&, Hit&, Observer&) {
    return Phase::done;
  }
  template <class Observer>
  static Phase descend(int, const Ray&, State&, Hit&, Observer&) {
    return Phase::done;
  }
  template <class Observer>
  static Phase intersect(int, const Ray&, State&, Hit&, Observer&) {
    return Phase::done;
  }
  template <class Observer>
  static Phase backtrack(int, const Ray&, State&, Hit&, Observer&) {
    return Phase::done;
  }
};

TEST(AnyTraverser, TakesTheStepsOfTheTraverserAndSeesAllThatTheyDo) {
  AnyTraverser::View any;
  {
    const Recorded::View view{5, 3};
    any = any_view<Recorded>(view);  // keeps a copy
  }
  AnyStates states(any, 3);
  EXPECT_EQ(states.size_bytes(), 3 * (sizeof(Recorded::State) + sizeof(Recorded::Stack)));
  const AnyTraverser::State state = states[1];
  EXPECT_EQ(static_cast<std::byte*>(states[2].state) - static_cast<std::byte*>(state.state),
            std::ptrdiff_t{sizeof(Recorded::State)});

  const Ray ray{.org = {}, .dir = {0, 0, 1}};
  Hit hit;
  StepObserver seen;
  EXPECT_EQ(AnyTraverser::begin(any, ray, state, hit, seen), Phase::descend);
  EXPECT_EQ(static_cast<Recorded::State*>(state.state)->stack, state.stack) << "the state points to its ray's stack";
  EXPECT_FALSE(seen.leaf_reached);
  EXPECT_EQ(AnyTraverser::descend(any, ray, state, hit, seen), Phase::intersect);
  EXPECT_TRUE(seen.leaf_reached);
  EXPECT_EQ(AnyTraverser::intersect(any, ray, state, hit, seen), Phase::backtrack);
  EXPECT_EQ(any.leaf(state), 12u) << "(1 * 10) + 2: begin, descend, intersect";
  EXPECT_EQ(AnyTraverser::backtrack(any, ray, state, hit, seen), Phase::done);
  EXPECT_EQ(hit.prim_id, 9u);
  EXPECT_EQ(hit.t, 0.5f);

  const Counters& c = seen.counters;
  EXPECT_EQ(c.node_steps, 1u);
  EXPECT_EQ(c.leaf_visits, 1u);
  EXPECT_EQ(c.box_tests, 2u);
  EXPECT_EQ(c.triangle_tests, 1u);
  EXPECT_EQ(c.backtracks, 1u);
  EXPECT_EQ(c.bytes[static_cast<int>(Memory::node)], 5u);
  EXPECT_EQ(c.bytes[static_cast<int>(Memory::stack)], 3u + 5u);
  EXPECT_EQ(seen.bytes_stored[static_cast<int>(Memory::stack)], 3u);
  EXPECT_EQ(seen.bytes_stored[static_cast<int>(Memory::node)], 0u);
}

TEST(AnyTraverser, LanesHearOfLoadsAndStores) {
  const AnyTraverser::View any = any_view<Recorded>({4, 8});
  AnyStates states(any, 1);
  WarpRequests requests;
  LaneObserver lane(requests, states[0].stack, any.stack_bytes, 0);
  StepObserver observer;
  observer.lane = &lane;
  const Ray ray{.org = {}, .dir = {0, 0, 1}};
  Hit hit;
  AnyTraverser::begin(any, ray, states[0], hit, observer);
  AnyTraverser::backtrack(any, ray, states[0], hit, observer);
  SimtProfile profile;
  requests.close(profile);
  EXPECT_EQ(profile.of(Memory::stack).requests, 2u) << "a store and a load";
  EXPECT_EQ(profile.of(Memory::stack).bytes, 8u + 4u);
  EXPECT_EQ(profile.of(Memory::stack).lines, 2u + 1u) << "words of a stack are 128 bytes apart";
}

TEST(AnyTraverser, SaysWhetherTheTraverserSpeculates) {
  EXPECT_EQ(any_view<Recorded>({0, 0}).after_leaf, Phase::backtrack);
  const AnyTraverser::View plain = any_view<Plain>(0);
  EXPECT_EQ(plain.leaf, nullptr);
  EXPECT_EQ(plain.stack_bytes, 0u);
  EXPECT_EQ(AnyStates(plain, 2)[1].stack, nullptr);
}

}  // namespace
}  // namespace accel
