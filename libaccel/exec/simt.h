// The SIMT model: 32 lanes in lockstep on the CPU, driving the same state machines as every other executor.
//
// The schedules are those of Aila and Laine 2009, "Understanding the Efficiency of Ray Traversal on GPUs" [AL09], section 3.
// One step runs one phase function for all lanes that are in its phase, while the others wait. "To the next node" in the
// paper's loops is descend or backtrack here: a lane that misses both children takes its next node from the stack without
// leaving the loop.
//
//   while-while   while a lane is at work: while a lane looks for a leaf: to the next node; then, while a lane has triangles
//                 left in its leaf: test one
//   if-if         while a lane is at work: to the next node, for lanes that look for a leaf; test one triangle, for lanes that
//                 have one
//   speculative   while-while, but a lane that has found a leaf postpones it and looks for another until all lanes hold one:
//                 section 3.2. Only for traversers that say how (SpeculativeTraverser); others run while-while
//   persistent    while-while, but lanes without work fetch rays from a queue: section 3.3. Deviation: lanes fetch one by one,
//                 once few enough are left at work, as in Aila, Laine and Karras 2012; in [AL09] a warp fetches 32 rays a time
//
//   if-while      while a lane is at work: to the next node, for lanes that look for a leaf; then, while a lane has triangles
//                 left in its leaf: test one. Not of [AL09]: it keeps lanes together that go through the same list of leaves,
//                 as in Garanzha and Loop 2010, Fig. 10 (packet/localized_ray.h)
//
// Hits are those of exec/cpu.h, bit for bit. A speculating lane visits nodes that a hit in its postponed leaf would have
// culled, which costs steps but no hit: the nearest hit does not depend on the order of tests, and any-hit meets the same
// leaves in the same order. One exception: a hit that rounding has moved out of its box (core/hit.h) may be found by
// speculation alone. The profile is the same for any number of threads: warps never share anything.
#pragma once

#include <span>

#include "libaccel/exec/any_traverser.h"
#include "libaccel/exec/simt_profile.h"

namespace accel {

// Runs the rays on modelled warps: consecutive rays share a warp, 32 of them or, when persistent, options.rays_per_warp.
// hits[i] answers rays[i]; pass an empty span if the profile is all that is wanted. O(steps of the CPU executor), some ten
// times slower. May throw std::bad_alloc.
SimtProfile simulate_simt(const AnyTraverser::View& view, std::span<const Ray> rays, std::span<Hit> hits,
                          const SimtOptions& options, int threads);

template <class Traverser>
SimtProfile simulate_simt(const typename Traverser::View& view, std::span<const Ray> rays, std::span<Hit> hits,
                          const SimtOptions& options, int threads) {
  return simulate_simt(any_view<Traverser>(view), rays, hits, options, threads);
}

}  // namespace accel
