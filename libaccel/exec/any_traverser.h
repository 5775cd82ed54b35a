// A traverser behind function pointers: what counters and models of machines drive, which are so compiled once, and not once
// more for each traverser, test and query. It takes the traverser's own steps, so hits are the same, bit for bit. Executors for
// speed (exec/cpu.h, exec/cuda) inline their traversers instead.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>

#include "libaccel/core/buffer.h"
#include "libaccel/exec/counters.h"
#include "libaccel/exec/simt_traffic.h"
#include "libaccel/trace/traverser.h"

namespace accel {

// Sees all that any executor asks for, so that a traverser is compiled for one observer and not for each.
struct StepObserver : CountingObserver {
  std::uint64_t bytes_stored[kMemoryClasses] = {};  // those of counters.bytes that were not loaded
  bool leaf_reached = false;                        // since it was last set to false
  LaneObserver* lane = nullptr;                     // hears of loads and stores, too

  void load(Memory memory, const void* address, std::uint32_t bytes) {
    CountingObserver::load(memory, address, bytes);
    if (lane != nullptr) lane->load(memory, address, bytes);
  }
  void store(Memory memory, const void* address, std::uint32_t bytes) {
    CountingObserver::store(memory, address, bytes);
    bytes_stored[static_cast<int>(memory)] += bytes;
    if (lane != nullptr) lane->store(memory, address, bytes);
  }
  void leaf_visit(std::uint32_t leaf) {
    CountingObserver::leaf_visit(leaf);
    leaf_reached = true;
  }
};

// A traverser (trace/traverser.h) whose view says which one it is.
struct AnyTraverser {
  // Where a ray's State and Stack are: uninitialised memory until begin().
  struct State {
    void* state;
    void* stack;
  };
  using Step = Phase (*)(const void* view, const Ray&, State, Hit&, StepObserver&);

  struct View {
    std::shared_ptr<const void> view;  // the traverser's, which may itself refer to a structure
    std::size_t state_bytes, stack_bytes;
    Step begin, descend, intersect, backtrack;
    // See SpeculativeTraverser; null where the traverser does not say how.
    std::uint32_t& (*leaf)(State) = nullptr;
    Phase after_leaf = Phase::done;
  };

  static Phase begin(const View& v, const Ray& ray, State s, Hit& hit, StepObserver& observer) {
    return v.begin(v.view.get(), ray, s, hit, observer);
  }
  static Phase descend(const View& v, const Ray& ray, State s, Hit& hit, StepObserver& observer) {
    return v.descend(v.view.get(), ray, s, hit, observer);
  }
  static Phase intersect(const View& v, const Ray& ray, State s, Hit& hit, StepObserver& observer) {
    return v.intersect(v.view.get(), ray, s, hit, observer);
  }
  static Phase backtrack(const View& v, const Ray& ray, State s, Hit& hit, StepObserver& observer) {
    return v.backtrack(v.view.get(), ray, s, hit, observer);
  }
};

namespace detail {

// A traverser's steps as functions of what AnyTraverser keeps.
template <class Traverser>
struct Steps {
  using View = typename Traverser::View;
  using State = typename Traverser::State;
  using Stack = StackOf<Traverser>;
  static_assert(alignof(State) <= kBufferAlignment && alignof(Stack) <= kBufferAlignment);

  static const View& view_of(const void* view) { return *static_cast<const View*>(view); }
  static State& state_of(AnyTraverser::State s) { return *std::launder(static_cast<State*>(s.state)); }

  static Phase begin(const void* view, const Ray& ray, AnyTraverser::State s, Hit& hit, StepObserver& observer) {
    State& state = *new (s.state) State;
    if constexpr (StackTraverser<Traverser>) attach_stack<Traverser>(state, *new (s.stack) Stack);
    return Traverser::begin(view_of(view), ray, state, hit, observer);
  }
  static Phase descend(const void* view, const Ray& ray, AnyTraverser::State s, Hit& hit, StepObserver& observer) {
    return Traverser::descend(view_of(view), ray, state_of(s), hit, observer);
  }
  static Phase intersect(const void* view, const Ray& ray, AnyTraverser::State s, Hit& hit, StepObserver& observer) {
    return Traverser::intersect(view_of(view), ray, state_of(s), hit, observer);
  }
  static Phase backtrack(const void* view, const Ray& ray, AnyTraverser::State s, Hit& hit, StepObserver& observer) {
    return Traverser::backtrack(view_of(view), ray, state_of(s), hit, observer);
  }
  static std::uint32_t& leaf(AnyTraverser::State s) { return Traverser::leaf(state_of(s)); }
};

}  // namespace detail

// The traverser with its view, of which this keeps a copy. May throw std::bad_alloc.
template <class Traverser>
AnyTraverser::View any_view(const typename Traverser::View& view) {
  using Steps = detail::Steps<Traverser>;
  AnyTraverser::View any{.view = std::make_shared<const typename Traverser::View>(view),
                         .state_bytes = sizeof(typename Steps::State),
                         .stack_bytes = StackTraverser<Traverser> ? sizeof(typename Steps::Stack) : 0,
                         .begin = Steps::begin,
                         .descend = Steps::descend,
                         .intersect = Steps::intersect,
                         .backtrack = Steps::backtrack};
  if constexpr (SpeculativeTraverser<Traverser>) any.leaf = Steps::leaf, any.after_leaf = Traverser::kAfterLeaf;
  return any;
}

// The states and stacks of `count` rays. May throw std::bad_alloc.
class AnyStates {
 public:
  AnyStates(const AnyTraverser::View& view, std::size_t count)
      : state_bytes_(view.state_bytes),
        stack_bytes_(view.stack_bytes),
        states_(count * state_bytes_),
        stacks_(count * stack_bytes_) {}

  AnyTraverser::State operator[](std::size_t i) {
    return {states_.data() + i * state_bytes_, stack_bytes_ == 0 ? nullptr : stacks_.data() + i * stack_bytes_};
  }
  std::size_t size_bytes() const { return states_.size_bytes() + stacks_.size_bytes(); }

 private:
  std::size_t state_bytes_, stack_bytes_;
  Buffer<std::byte> states_, stacks_;
};

}  // namespace accel
