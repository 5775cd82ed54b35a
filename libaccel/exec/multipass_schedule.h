// Which kernel of the multipass executor runs next: Foley and Sugerman 2005 [FS05], section 3.4, after Delany 1988, "Ray
// tracing on a connection machine". The executors for CPUs and CUDA share it.
//
// [FS05] runs a kernel "until the estimate for the next kernel is more than twice the estimate for the current one". The next
// kernel is here the first behind it in the data flow that any ray waits for: with all rays in one kernel there is none, and
// the traversers that know no Up step (kd-restart) skip it. Deviation: counts are exact, read after every pass, where the paper
// estimates them by occlusion queries.
//
// Termination. A kernel is chosen only if rays wait for it, a pass takes each of them one step on, and a traversal has finitely
// many steps. No ray starves: those that others are preferred to become the majority in the end, or all that is left.
#pragma once

#include "libaccel/core/result.h"
#include "libaccel/exec/multipass_profile.h"

namespace accel {

// The first kernel behind `current`, in the order of the data flow, that rays wait for; `current` itself comes last.
inline MultipassKernel next_in_flow(MultipassKernel current, const MultipassCounts& waiting) {
  for (int step = 1; step < kMultipassKernels; ++step) {
    const auto kernel = static_cast<MultipassKernel>((static_cast<int>(current) + step) % kMultipassKernels);
    if (waiting[kernel] > 0) return kernel;
  }
  return current;
}

// The kernel that most rays wait for; of several the first in the data flow.
inline MultipassKernel largest_kernel(const MultipassCounts& waiting) {
  auto largest = MultipassKernel::initialize;
  for (int k = 1; k < kMultipassKernels; ++k) {
    const auto kernel = static_cast<MultipassKernel>(k);
    if (waiting[kernel] > waiting[largest]) largest = kernel;
  }
  return largest;
}

// The kernel to run after `current`, for which rays are waiting as long as they wait for any.
inline MultipassKernel choose_kernel(MultipassRule rule, MultipassKernel current, const MultipassCounts& waiting) {
  if (rule == MultipassRule::largest_first) return largest_kernel(waiting);
  const MultipassKernel next = next_in_flow(current, waiting);
  if (waiting[current] == 0) return next;
  const bool leave = rule == MultipassRule::delany && waiting[next] > 2 * std::uint64_t{waiting[current]};
  return leave ? next : current;
}

// Takes `rays` rays from initialize to their ends. run_pass(kernel, waiting) runs one kernel for all rays that wait for it,
// updates the counts and returns a Status; the first failure ends everything.
template <class RunPass>
Status run_passes(MultipassRule rule, std::uint32_t rays, const RunPass& run_pass) {
  MultipassCounts waiting;
  auto kernel = MultipassKernel::initialize;
  waiting[kernel] = rays;
  while (waiting.total() > 0) {
    kernel = choose_kernel(rule, kernel, waiting);
    if (Status status = run_pass(kernel, waiting); !status) return status;
  }
  return Done{};
}

}  // namespace accel
