// The definition of make_device_method(): all kernels of one method. Only the sources that the build makes for each method
// include this (cmake/AccelMethods.cmake).
#pragma once

#include <algorithm>
#include <type_traits>

#include "libaccel/exec/cuda/device_memory.cuh"
#include "libaccel/exec/cuda/device_method.cuh"
#include "libaccel/exec/cuda/launch_multipass.cuh"
#include "libaccel/exec/cuda/launch_packets.cuh"
#include "libaccel/exec/cuda/launch_trace.cuh"
#include "libaccel/exec/cuda/trace_kernel.cuh"

namespace accel::cuda {

namespace detail {

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

template <Query kQuery>
auto store_of(const Launch& launch) {
  if constexpr (kQuery == Query::closest)
    return StoreHits{launch.hits};
  else
    return StoreOccluded{launch.occluded};
}

// In passes, with the traverser that serves the structure best.
template <Query kQuery>
struct MultipassVisitor {
  const Launch& launch;
  template <class Best>
  Status operator()(std::type_identity<Best>) const {
    if constexpr (kQuery == Query::closest)
      return launch_multipass<Best>(launch, KeepHits{});
    else
      return launch_multipass<Best>(launch, store_of<kQuery>(launch));
  }
};

// What packets leave is traced by the kernel of single rays.
template <class Traverser, class Test, Query kQuery>
Status launch_as_packets(const Launch& launch) {
  const TraceOthers trace_others = [](const Launch& others, const std::uint32_t* ids) {
    return launch_best_trace_kernel<Traverser>(others, StoreListed{ids, store_of<kQuery>(others)});
  };
  return launch_packets(*std::any_cast<typename Traverser::View>(&launch.view), ModelledTests::index_of<Test>(), kQuery, launch,
                        trace_others);
}

template <class Method, class Test, Query kQuery>
Status launch_trace(const Launch& launch) {
  using Traverser = typename Method::template Traverser<Test, kQuery>;
  if (launch.policy == LaunchPolicy::multipass)
    return with_traverser<Traverser, Machine::device>(*std::any_cast<typename Traverser::View>(&launch.view),
                                                      MultipassVisitor<kQuery>{launch});
  if constexpr (PacketTraverser<Traverser>)
    return launch_as_packets<Traverser, Test, kQuery>(launch);
  else
    return launch_best_trace_kernel<Traverser>(launch, store_of<kQuery>(launch));
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
  result.makes_packets = PacketTraverser<typename Method::template Traverser<Watertight, Query::closest>>;
  std::size_t i = 0;
  ModelledTests::for_each([&](auto tag) {
    using Test = typename decltype(tag)::type;
    result.kernels[i] = {detail::launch_trace<Method, Test, Query::closest>, detail::launch_trace<Method, Test, Query::any>};
    result.ray_sizes[i++] = {detail::ray_sizes<typename Method::template Traverser<Test, Query::closest>>(),
                             detail::ray_sizes<typename Method::template Traverser<Test, Query::any>>()};
  });
  return result;
}

}  // namespace accel::cuda
