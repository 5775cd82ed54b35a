// Traversers that trace batches of rays in a way of their own.
//
// Such a traverser has a class template `Batch<TraceSingly>`, whose objects are made of a view, its Options and a function that
// traces a single ray, and have trace(rays, answers): see packet/packet_tracer.h. What concerns single rays is the traverser's
// own.
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

// What a batch is made with.
template <BatchTraverser Traverser>
using BatchOptions = typename Traverser::template Batch<detail::TraceSingly>::Options;

}  // namespace accel
