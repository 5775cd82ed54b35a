// The definition of make_device_method(): all kernels of one method. Only the sources that the build makes for each method
// include this (cmake/AccelMethods.cmake).
#pragma once

#include <algorithm>
#include <type_traits>

#include "libaccel/exec/cuda/device_memory.cuh"
#include "libaccel/exec/cuda/device_method.cuh"
#include "libaccel/exec/cuda/launch_multipass.cuh"
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

// In batches of as many rays as there is room for. The hits are worked on in place; `finish` does what else an answer needs.
template <class Traverser, class Finish>
Status launch_multipass(const Launch& launch, const Finish& finish) {
  const auto& view = *std::any_cast<typename Traverser::View>(&launch.view);
  for (std::uint32_t begin = 0; begin < launch.ray_count;) {
    const std::uint32_t count = std::min(launch.in_flight->capacity, launch.ray_count - begin);
    MultipassRun<Traverser, Finish> run(view, *launch.in_flight, launch.rays + begin, launch.hits + begin, finish.from(begin));
    if (const Status s = run.run(launch.rule, count); !s) return s;
    begin += count;
  }
  return Done{};
}

template <class Traverser, class Store>
Status launch_with(const Launch& launch, const Store& store) {
  const auto& view = *std::any_cast<typename Traverser::View>(&launch.view);
  if (launch.policy == LaunchPolicy::grid) {
    trace_kernel<Traverser, GridWork, Store>
        <<<blocks_for(launch.ray_count), kBlockSize>>>(view, launch.rays, {launch.ray_count}, store);
  } else {
    const auto kernel = trace_kernel<Traverser, PersistentWork, Store>;
    const Result<unsigned> blocks = resident_blocks(kernel, launch.ray_count);
    if (!blocks) return blocks.error();
    kernel<<<*blocks, kBlockSize>>>(view, launch.rays, {launch.ray_count, launch.next_ray}, store);
  }
  ACCEL_CUDA_TRY(cudaGetLastError());
  return Done{};
}

template <class Traverser, Query kQuery>
Status launch_traverser(const Launch& launch) {
  const bool in_passes = launch.policy == LaunchPolicy::multipass;
  if constexpr (kQuery == Query::closest) {
    if (in_passes) return launch_multipass<Traverser>(launch, KeepHits{});
    return launch_with<Traverser>(launch, StoreHits{launch.hits});
  } else {
    const StoreOccluded store{launch.occluded};
    return in_passes ? launch_multipass<Traverser>(launch, store) : launch_with<Traverser>(launch, store);
  }
}

// The launch of the traverser that serves the structure best.
template <class Traverser, Query kQuery>
struct LaunchVisitor {
  const Launch& launch;
  template <class Best>
  Status operator()(std::type_identity<Best>) const {
    return launch_traverser<Best, kQuery>(launch);
  }
};

template <class Method, class Test, Query kQuery>
Status launch_trace(const Launch& launch) {
  using Traverser = typename Method::template Traverser<Test, kQuery>;
  return with_traverser<Traverser, Machine::device>(*std::any_cast<typename Traverser::View>(&launch.view),
                                                    LaunchVisitor<Traverser, kQuery>{launch});
}

template <class Traverser>
constexpr RaySizes ray_sizes() {
  return {sizeof(typename Traverser::State), StackTraverser<Traverser> ? sizeof(StackOf<Traverser>) : 0};
}

template <class Method>
std::any upload_structure(const AnyStructure& any, Uploader& uploader) {
  return upload(*any.get_if<typename Method::Structure>(), uploader);
}

}  // namespace detail

template <class Method>
DeviceMethod make_device_method() {
  DeviceMethod result;
  result.name = Method::name();
  result.upload = detail::upload_structure<Method>;
  std::size_t i = 0;
  TriangleTests::for_each([&](auto tag) {
    using Test = typename decltype(tag)::type;
    result.kernels[i] = {detail::launch_trace<Method, Test, Query::closest>, detail::launch_trace<Method, Test, Query::any>};
    result.ray_sizes[i++] = {detail::ray_sizes<typename Method::template Traverser<Test, Query::closest>>(),
                             detail::ray_sizes<typename Method::template Traverser<Test, Query::any>>()};
  });
  return result;
}

}  // namespace accel::cuda
