// Launches of the kernel that traces rays one by one (trace_kernel.cuh).
#pragma once

#include <algorithm>
#include <any>
#include <cstdint>
#include <type_traits>

#include "libaccel/exec/cuda/device_memory.cuh"
#include "libaccel/exec/cuda/device_method.cuh"
#include "libaccel/exec/cuda/trace_kernel.cuh"

namespace accel::cuda {

namespace detail {

constexpr unsigned blocks_for(std::uint32_t threads) { return (threads + kBlockSize - 1) / kBlockSize; }

// As many blocks as run at the same time, but no more than there are rays for.
template <class Kernel>
Result<unsigned> resident_blocks(Kernel kernel, std::uint32_t ray_count) {
  int device = 0, multiprocessors = 0, blocks_each = 0;
  ACCEL_CUDA_TRY(cudaGetDevice(&device));
  ACCEL_CUDA_TRY(cudaDeviceGetAttribute(&multiprocessors, cudaDevAttrMultiProcessorCount, device));
  ACCEL_CUDA_TRY(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks_each, kernel, kBlockSize, 0));
  return std::min(static_cast<unsigned>(multiprocessors) * static_cast<unsigned>(blocks_each), blocks_for(ray_count));
}

}  // namespace detail

// By the launch's policy, grid or persistent.
template <class Traverser, class Store>
Status launch_trace_kernel(const Launch& launch, const Store& store) {
  const auto& view = *std::any_cast<typename Traverser::View>(&launch.view);
  if (launch.policy == LaunchPolicy::grid) {
    trace_kernel<Traverser, GridWork, Store>
        <<<detail::blocks_for(launch.ray_count), kBlockSize>>>(view, launch.rays, {launch.ray_count}, store);
  } else {
    const auto kernel = trace_kernel<Traverser, PersistentWork, Store>;
    const Result<unsigned> blocks = detail::resident_blocks(kernel, launch.ray_count);
    if (!blocks) return blocks.error();
    kernel<<<*blocks, kBlockSize>>>(view, launch.rays, {launch.ray_count, launch.next_ray}, store);
  }
  ACCEL_CUDA_TRY(cudaGetLastError());
  return Done{};
}

// With the traverser that serves the structure best.
template <class Store>
struct TraceKernelVisitor {
  const Launch& launch;
  const Store& store;
  template <class Best>
  Status operator()(std::type_identity<Best>) const {
    return launch_trace_kernel<Best>(launch, store);
  }
};

template <class Traverser, class Store>
Status launch_best_trace_kernel(const Launch& launch, const Store& store) {
  return with_traverser<Traverser, Machine::device>(*std::any_cast<typename Traverser::View>(&launch.view),
                                                    TraceKernelVisitor<Store>{launch, store});
}

}  // namespace accel::cuda
