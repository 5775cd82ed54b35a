#include "libaccel/exec/multipass_step.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace accel {
namespace {

using Kernel = MultipassKernel;

// What one call of a traverser does: says that it has reached a leaf, and which phase comes next.
struct Call {
  bool reaches_leaf;
  Phase next;
};

// A traverser whose calls are written down beforehand.
struct Scripted {
  using View = const Call*;
  struct State {
    std::size_t calls;
    std::string* names;
  };

  template <class Observer>
  static Phase call(const char* name, View script, State& state, Observer& observer) {
    *state.names += name;
    const Call& c = script[state.calls++];
    if (c.reaches_leaf) observer.leaf_visit(0);
    return c.next;
  }
  template <class Observer>
  static Phase begin(View v, const Ray& ray, State& s, Hit& hit, Observer& o) {
    begin_hit(ray, hit);
    return call("b", v, s, o);
  }
  template <class Observer>
  static Phase descend(View v, const Ray&, State& s, Hit&, Observer& o) {
    return call("d", v, s, o);
  }
  template <class Observer>
  static Phase intersect(View v, const Ray&, State& s, Hit&, Observer& o) {
    return call("i", v, s, o);
  }
  template <class Observer>
  static Phase backtrack(View v, const Ray&, State& s, Hit&, Observer& o) {
    return call("u", v, s, o);
  }
};

template <Kernel kKernel>
Kernel step(const Scripted::View& script, const MultipassRay<Scripted>& ray) {
  LeafObserver observer;
  return multipass_step<kKernel, Scripted>(script, ray, observer);
}

// The kernels that a ray goes through, and the calls that they make.
struct Trace {
  std::vector<Kernel> kernels;
  std::string calls;
};

Trace follow(const std::vector<Call>& script) {
  Trace trace;
  Scripted::State state{0, &trace.calls};
  const Ray ray{.org = {}, .dir = {0, 0, 1}};
  Hit hit;
  Phase phase = Phase::done;
  const MultipassRay<Scripted> r{ray, state, hit, phase};
  for (Kernel kernel = Kernel::initialize; kernel != Kernel::finished;) {
    trace.kernels.push_back(kernel);
    const Scripted::View view = script.data();
    visit_kernel(kernel, [&](auto k) { kernel = step<k()>(view, r); });
  }
  EXPECT_EQ(state.calls, script.size()) << "the traverser is called once for each of its phases";
  EXPECT_EQ(hit.t, Hit{}.t) << "misses are finished";
  return trace;
}

using Kernels = std::vector<Kernel>;
constexpr auto kInit = Kernel::initialize, kDown = Kernel::down, kLeaf = Kernel::leaf, kIntersect = Kernel::intersect,
               kContinue = Kernel::continue_search, kUp = Kernel::up;

TEST(MultipassStep, RaysThatEndAtOnceNeedOneKernel) {
  const Trace trace = follow({{false, Phase::done}});
  EXPECT_EQ(trace.kernels, (Kernels{kInit}));
}

TEST(MultipassStep, FollowsTheDataFlowOfThePaper) {
  // Down twice to a leaf of two triangles; the first step back is Continue, the other two are Up; then Down to the last leaf.
  const Trace trace = follow({{false, Phase::descend},
                              {false, Phase::descend},
                              {true, Phase::intersect},
                              {false, Phase::intersect},
                              {false, Phase::backtrack},
                              {false, Phase::backtrack},
                              {false, Phase::backtrack},
                              {false, Phase::descend},
                              {true, Phase::intersect},
                              {false, Phase::done}});
  EXPECT_EQ(trace.kernels, (Kernels{kInit, kDown, kDown, kLeaf, kIntersect, kIntersect, kContinue, kUp, kUp, kDown, kLeaf,
                                    kIntersect, kContinue}));
  EXPECT_EQ(trace.calls, "bddiiuuudi");
}

TEST(MultipassStep, EmptyLeavesAreTransitionsToo) {
  const Trace trace = follow({{false, Phase::descend},
                              {true, Phase::backtrack},
                              {false, Phase::descend},
                              {true, Phase::backtrack},
                              {false, Phase::done}});
  EXPECT_EQ(trace.kernels, (Kernels{kInit, kDown, kLeaf, kContinue, kDown, kLeaf, kContinue}));
}

TEST(MultipassStep, LeavesNextToEachOther) {
  // A rope, or an entry of the stack, that leads from leaf to leaf.
  const Trace trace =
      follow({{true, Phase::intersect}, {false, Phase::backtrack}, {true, Phase::intersect}, {false, Phase::done}});
  EXPECT_EQ(trace.kernels, (Kernels{kInit, kLeaf, kIntersect, kContinue, kLeaf, kIntersect, kContinue}));
}

TEST(MultipassStep, GridsNeedNoTransitionDownwards) {
  // An empty cell, then one with a triangle, after which the traverser goes on by itself.
  const Trace trace = follow({{true, Phase::descend}, {true, Phase::intersect}, {false, Phase::descend}, {false, Phase::done}});
  EXPECT_EQ(trace.kernels, (Kernels{kInit, kDown, kLeaf, kIntersect, kDown}));
}

TEST(MultipassStep, BacktrackingWithoutALeafIsUp) {
  const Trace trace =
      follow({{false, Phase::descend}, {false, Phase::backtrack}, {false, Phase::backtrack}, {false, Phase::done}});
  EXPECT_EQ(trace.kernels, (Kernels{kInit, kDown, kUp, kUp}));
}

}  // namespace
}  // namespace accel
