#include "libaccel/exec/cuda/launch_packets.cuh"

#include <algorithm>
#include <array>

#include "libaccel/exec/cuda/cuda_primitives.cuh"
#include "libaccel/exec/cuda/launch_trace.cuh"
#include "libaccel/exec/cuda/localized_kernel.cuh"
#include "libaccel/packet/packet_batch.h"

namespace accel::cuda {

namespace {

// Of the device's memory, for a ray of a block: see packet/packet_batch.h, and what sorts need.
constexpr std::size_t kBytesPerRay = 256;
constexpr std::size_t kSmallestBlock = 1u << 16;
// Pairs in the queue per ray of a frustum. More than on CPUs, which have groups of rays for what gives up.
constexpr float kBudget = 2;

// As many rays as are asked for, fewer where memory is short.
Result<std::uint32_t> block_size_for(std::uint32_t wanted) {
  std::size_t free = 0, all = 0;
  ACCEL_CUDA_TRY(cudaMemGetInfo(&free, &all));
  return static_cast<std::uint32_t>(std::min<std::size_t>(wanted, std::max(free / 2 / kBytesPerRay, kSmallestBlock)));
}

void set_answers(Launch& launch, Hit* hits) { launch.hits = hits; }
void set_answers(Launch& launch, std::uint8_t* occluded) { launch.occluded = occluded; }

template <class Test, Query kQuery, class Answer>
Status launch_localized(const LocalizedTasks& tasks, Answer* answers, std::uint32_t* next_task) {
  if (tasks.count == 0) return Done{};
  const auto kernel = localized_kernel<Test, kQuery, Answer>;
  const Result<unsigned> blocks = detail::resident_blocks(kernel, tasks.count);
  if (!blocks) return blocks.error();
  ACCEL_CUDA_TRY(cudaMemsetAsync(next_task, 0, sizeof *next_task));
  kernel<<<*blocks, kBlockSize>>>(tasks, answers, next_task);
  ACCEL_CUDA_TRY(cudaGetLastError());
  return Done{};
}

template <class Test, Query kQuery, class Answer>
Status launch_in_blocks(const Bvh2View& view, const Launch& launch, Answer* answers, const TraceOthers& trace_others) {
  const auto block_size = block_size_for(launch.packet_block);
  if (!block_size) return block_size.error();
  PacketOptions options;
  options.block_size = *block_size;
  options.budget = kBudget;
  const auto intersect = [&](const LocalizedTasks& tasks, Answer* block_answers) {
    if (!launch.packet_queues) return IntersectByRay<CudaPrimitives, Test, kQuery>{}(tasks, block_answers);
    const Status launched = launch_localized<Test, kQuery>(tasks, block_answers, launch.next_ray);
    if (!launched) throw DeviceFailure{launched.error()};
  };
  const auto trace_singly = [&](const Ray* rays, const std::uint32_t* ids, std::size_t count, Answer* block_answers) {
    Launch others = launch;
    others.rays = rays, others.ray_count = static_cast<std::uint32_t>(count);
    set_answers(others, block_answers);
    throw_unless_done(cudaMemsetAsync(others.next_ray, 0, sizeof *others.next_ray), "cudaMemsetAsync");
    if (const Status traced = trace_others(others, ids); !traced) throw DeviceFailure{traced.error()};
  };
  return caught(
      [&] { trace_packets<CudaPrimitives>(view, options, launch.rays, launch.ray_count, answers, intersect, trace_singly); });
}

using PacketLaunch = Status (*)(const Bvh2View&, const Launch&, const TraceOthers&);

template <class Test>
Status launch_closest(const Bvh2View& view, const Launch& launch, const TraceOthers& trace_others) {
  return launch_in_blocks<Test, Query::closest>(view, launch, launch.hits, trace_others);
}
template <class Test>
Status launch_any(const Bvh2View& view, const Launch& launch, const TraceOthers& trace_others) {
  return launch_in_blocks<Test, Query::any>(view, launch, launch.occluded, trace_others);
}

// By test and query.
std::array<std::array<PacketLaunch, 2>, ModelledTests::size> packet_launches() {
  std::array<std::array<PacketLaunch, 2>, ModelledTests::size> launches{};
  std::size_t i = 0;
  ModelledTests::for_each([&](auto tag) {
    using Test = typename decltype(tag)::type;
    launches[i++] = {launch_closest<Test>, launch_any<Test>};
  });
  return launches;
}

}  // namespace

Status launch_packets(const Bvh2View& view, std::size_t test, Query query, const Launch& launch,
                      const TraceOthers& trace_others) {
  static const auto kLaunches = packet_launches();
  return kLaunches[test][query == Query::any ? 1 : 0](view, launch, trace_others);
}

}  // namespace accel::cuda
