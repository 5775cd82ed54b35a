// Drives a traverser over one ray: the while-while loop of Aila and Laine 2009. The executors for CPUs and CUDA share it.
#pragma once

#include "libaccel/trace/traverser.h"

namespace accel {

// From the phase that comes next until the query is done.
template <class Traverser, class Observer>
ACCEL_HD void drive(const typename Traverser::View& view, const Ray& ray, typename Traverser::State& state, Hit& hit,
                    Phase phase, Observer& observer) {
  while (phase != Phase::done) {
    while (phase == Phase::descend) phase = Traverser::descend(view, ray, state, hit, observer);
    while (phase == Phase::intersect) phase = Traverser::intersect(view, ray, state, hit, observer);
    while (phase == Phase::backtrack) phase = Traverser::backtrack(view, ray, state, hit, observer);
  }
}

template <class Traverser, class Observer>
ACCEL_HD Hit trace_ray(const typename Traverser::View& view, const Ray& ray, Observer& observer) {
  StackOf<Traverser> stack;
  typename Traverser::State state{};  // compilers cannot see that a query that ends in begin() reads none of it
  attach_stack<Traverser>(state, stack);
  Hit hit;
  const Phase phase = Traverser::begin(view, ray, state, hit, observer);
  drive<Traverser>(view, ray, state, hit, phase, observer);
  finish_hit(hit);
  return hit;
}

}  // namespace accel
