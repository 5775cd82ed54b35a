// The multipass executor: rays as streams through the kernels Initialize, Down, Leaf, Intersect, Continue and Up.
//
// Foley and Sugerman 2005, "KD-Tree Acceleration Structures for a GPU Raytracer" [FS05], sections 3.3 and 3.4. Machines without
// branches run one small kernel over many rays, pass after pass. What a ray is doing lies in arrays between the passes; each
// pass takes all rays that wait for its kernel one step on. Kernels are the steps of trace/traverser.h, so any traverser of the
// registry runs, with a stack or without, and it is the code that the while-while executor (exec/cpu.h) runs: hits are the
// same, bit for bit, whatever the options. exec/multipass_step.h says which step is which kernel, exec/multipass_schedule.h
// which kernel runs next, exec/multipass_profile.h what is counted.
//
// Deviations. One pass of Intersect tests one triangle of each ray, as the paper's counts suggest; counts of waiting rays are
// exact; rays can be compacted instead of masked. Rays beyond batch_size wait for the next batch, so that memory is bounded.
//
// The profile is exact and the same for any number of threads. O(steps) work, and O(passes * batch) more where passes are
// masked. Memory: a State, a Hit, a Stack and up to 30 bytes for each ray in flight.
#pragma once

#include <span>

#include "libaccel/exec/any_traverser.h"
#include "libaccel/exec/multipass_profile.h"

namespace accel {

// Traces and counts. hits[i] answers rays[i], as exec/cpu.h does; pass an empty span if the profile is all that is wanted.
// May throw std::bad_alloc.
MultipassProfile trace_multipass(const AnyTraverser::View& view, std::span<const Ray> rays, std::span<Hit> hits,
                                 const MultipassOptions& options, int threads);

template <class Traverser>
MultipassProfile trace_multipass(const typename Traverser::View& view, std::span<const Ray> rays, std::span<Hit> hits,
                                 const MultipassOptions& options, int threads) {
  return trace_multipass(any_view<Traverser>(view), rays, hits, options, threads);
}

}  // namespace accel
