// Traversers that trace batches of rays in a way of their own.
//
// Such a traverser has a class template `Batch<TraceSingly>`, whose objects are made of a view, its Options and a function that
// traces a single ray, and have trace(rays, answers): see packet/packet_tracer.h. What concerns single rays is the traverser's
// own, and batches of fewer than Batch::kFewestRays are traced ray by ray. A thread gets Options::block_size rays at a time,
// or, where there is such a function, as many as Batch::rays_per_task(rays, options) says. A batch whose code is for some
// triangle tests, and which serves others by the way, says so: `kIsTuned` is false for those. One that has code for a ray alone
// has a static trace_one(view, ray, answer).
#pragma once

#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"

namespace accel {

namespace detail {
struct TraceSingly {
  Hit operator()(const Ray&) const;
};
}  // namespace detail

template <class Traverser>
concept BatchTraverser = requires {
  typename Traverser::template Batch<detail::TraceSingly>;
};

// Whether the traverser's code on CPUs is written for its triangle test.
template <class Traverser>
constexpr bool is_tuned() {
  if constexpr (BatchTraverser<Traverser>) {
    using Batch = typename Traverser::template Batch<detail::TraceSingly>;
    if constexpr (requires { Batch::kIsTuned; }) return Batch::kIsTuned;
  }
  return true;
}

// What a batch is made with.
template <BatchTraverser Traverser>
using BatchOptions = typename Traverser::template Batch<detail::TraceSingly>::Options;

}  // namespace accel
