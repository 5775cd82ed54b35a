// Traces one ray hit by hit: trace/bvh2_pause.h.
#pragma once

#include "libaccel/exec/drive.h"
#include "libaccel/trace/bvh2_pause.h"

namespace accel {

// A hit, and where the traversal is paused at it. After a miss nothing comes.
struct PausedHit {
  Hit hit;
  PausedTraversal paused;
};

namespace detail {
template <class Traverser, class Begin, class Observer>
ACCEL_HD PausedHit trace_to_hit(const typename Traverser::View& view, const Ray& ray, const Begin& begin, Observer& observer) {
  typename Traverser::State state{};
  Hit hit;
  const Phase phase = begin(state, hit);
  drive<Traverser>(view, ray, state, hit, phase, observer);
  finish_hit(hit);
  return {hit, state.paused};
}
}  // namespace detail

template <class Traverser, class Observer>
ACCEL_HD PausedHit first_hit(const typename Traverser::View& view, const Ray& ray, Observer& observer) {
  const auto begin = [&](auto& state, Hit& hit) { return Traverser::begin(view, ray, state, hit, observer); };
  return detail::trace_to_hit<Traverser>(view, ray, begin, observer);
}

// The hit behind the one where it was paused.
template <class Traverser, class Observer>
ACCEL_HD PausedHit next_hit(const typename Traverser::View& view, const Ray& ray, const PausedTraversal& paused,
                            Observer& observer) {
  const auto begin = [&](auto& state, Hit& hit) { return Traverser::resume(view, ray, paused, state, hit, observer); };
  return detail::trace_to_hit<Traverser>(view, ray, begin, observer);
}

}  // namespace accel
