// The host's side of the multipass executor on a device: chooses kernels, launches passes, reads back who waits for what.
//
// Every pass ends with a copy of six counts to the host, by which the next kernel is chosen (exec/multipass_schedule.h): some
// ten microseconds a pass, little beside a pass over millions of rays, much beside one over the last thousand.
#pragma once

#include <algorithm>
#include <array>

#include "libaccel/exec/cuda/multipass_kernel.cuh"
#include "libaccel/exec/cuda/multipass_memory.cuh"
#include "libaccel/exec/multipass_schedule.h"

namespace accel::cuda {

// One batch of rays, from initialize to their ends.
template <class Traverser, class Finish>
class MultipassRun {
 public:
  MultipassRun(const typename Traverser::View& view, MultipassMemory& memory, const Ray* rays, Hit* hits, const Finish& finish)
      : view_(view),
        finish_(finish),
        streams_{rays, hits, reinterpret_cast<typename Traverser::State*>(memory.states.data()),
                 reinterpret_cast<StackOf<Traverser>*>(memory.stacks.data()), memory.phases.data()},
        lists_(memory.lists.data(), memory.capacity, memory.sizes.data()) {}

  Status run(MultipassRule rule, std::uint32_t count) {
    ACCEL_CUDA_TRY(cudaMemset(lists_.sizes, 0, kMultipassKernels * sizeof(std::uint32_t)));
    return run_passes(rule, count, [this](MultipassKernel kernel, MultipassCounts& waiting) { return pass(kernel, waiting); });
  }

 private:
  Status pass(MultipassKernel kernel, MultipassCounts& waiting) {
    const std::uint32_t* list = lists_.begin_pass(kernel);
    ACCEL_CUDA_TRY(cudaMemsetAsync(lists_.sizes + static_cast<std::size_t>(kernel), 0, sizeof(std::uint32_t)));
    visit_kernel(kernel, [&](auto k) { launch<k()>(list, waiting[kernel]); });
    ACCEL_CUDA_TRY(cudaGetLastError());
    std::array<std::uint32_t, kMultipassKernels> sizes;
    ACCEL_CUDA_TRY(cudaMemcpy(sizes.data(), lists_.sizes, sizeof sizes, cudaMemcpyDeviceToHost));
    for (std::size_t i = 0; i < sizes.size(); ++i) waiting[static_cast<MultipassKernel>(i)] = sizes[i];
    return Done{};
  }

  template <MultipassKernel kKernel>
  void launch(const std::uint32_t* list, std::uint32_t count) {
    const unsigned blocks = (count + kBlockSize - 1) / kBlockSize;
    multipass_kernel<Traverser, kKernel, Finish><<<blocks, kBlockSize>>>(view_, streams_, list, count, lists_, finish_);
  }

  const typename Traverser::View& view_;
  const Finish finish_;
  MultipassStreams<Traverser> streams_;
  MultipassLists lists_;
};

}  // namespace accel::cuda
