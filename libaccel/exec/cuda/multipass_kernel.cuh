// The kernels of the multipass executor: one step of one kind for every ray that waits for it. Foley and Sugerman 2005 [FS05],
// sections 3.3 and 3.4; see exec/multipass.h, whose twin on the device this is.
//
// The rays that wait for a kernel are listed in device memory. A pass has one thread for each entry of its list; it takes the
// ray one step on and appends it to the list of the kernel that it goes to, with one atomic a warp and list. A ray is in one
// list at a time, so lists with room for all rays never overflow. What stays in a kernel goes to the spare list, which the host
// exchanges for the kernel's own. The order within lists varies from run to run; hits do not.
//
// States lie in an array of structures, which a step changes in place: it reads and writes no more than its kernel needs, and a
// ray's state is in neighbouring sectors however the lists have mixed the rays. Deviation: [FS05] masks rays instead.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "libaccel/exec/cuda/trace_kernel.cuh"
#include "libaccel/exec/multipass_step.h"

namespace accel::cuda {

// Everything about the rays in flight, by ray.
template <class Traverser>
struct MultipassStreams {
  const Ray* rays;
  Hit* hits;
  typename Traverser::State* states;
  StackOf<Traverser>* stacks;  // null where the traverser needs none
  Phase* phases;
};

// The lists that a pass appends to, by kernel, and their sizes.
struct MultipassLists {
  std::uint32_t* rays[kMultipassKernels];
  std::uint32_t* spare;
  std::uint32_t* sizes;

  // In memory for kMultipassKernels + 1 lists of `capacity` rays, and kMultipassKernels sizes.
  MultipassLists(std::uint32_t* memory, std::size_t capacity, std::uint32_t* size_memory) : sizes(size_memory) {
    for (std::uint32_t*& list : rays) list = std::exchange(memory, memory + capacity);
    spare = memory;
  }

  // The list that a pass of the kernel reads; none is all rays. Rays that stay go to the spare list, which is now the kernel's.
  const std::uint32_t* begin_pass(MultipassKernel kernel) {
    std::uint32_t*& list = rays[static_cast<std::size_t>(kernel)];
    std::swap(list, spare);
    return kernel == MultipassKernel::initialize ? nullptr : spare;
  }
};

// What is done with the answer of a ray that has ended, beside leaving it among the hits.
struct KeepHits {
  __device__ void operator()(std::uint32_t, const Hit&) const {}
  KeepHits from(std::uint32_t) const { return {}; }
};

// Appends each lane's ray to the list of the kernel that it goes to. All lanes of a warp take part.
__device__ inline void append(const MultipassLists& lists, std::uint32_t ray, MultipassKernel goes_to) {
  const int lane = static_cast<int>(threadIdx.x % warpSize);
  const unsigned lanes_below = (1u << lane) - 1u;
  for (int k = 0; k < kMultipassKernels; ++k) {
    const bool mine = goes_to == static_cast<MultipassKernel>(k);
    const unsigned lanes = __ballot_sync(kAllLanes, mine);
    if (lanes == 0) continue;
    const int leader = __ffs(static_cast<int>(lanes)) - 1;
    std::uint32_t first = 0;
    if (lane == leader) first = atomicAdd(lists.sizes + k, static_cast<std::uint32_t>(__popc(lanes)));
    first = __shfl_sync(kAllLanes, first, leader);
    if (mine) lists.rays[k][first + static_cast<std::uint32_t>(__popc(lanes & lanes_below))] = ray;
  }
}

// One pass over `count` entries of `list`; without a list over the rays [0, count).
template <class Traverser, MultipassKernel kKernel, class Finish>
__global__ void __launch_bounds__(kBlockSize)
    multipass_kernel(const typename Traverser::View view, const MultipassStreams<Traverser> streams, const std::uint32_t* list,
                     const std::uint32_t count, const MultipassLists lists, const Finish finish) {
  const std::uint32_t thread = blockIdx.x * blockDim.x + threadIdx.x;
  std::uint32_t index = 0;
  MultipassKernel goes_to = MultipassKernel::finished;
  if (thread < count) {
    index = list == nullptr ? thread : list[thread];
    if constexpr (kKernel == MultipassKernel::initialize && StackTraverser<Traverser>)
      attach_stack<Traverser>(streams.states[index], streams.stacks[index]);
    const Ray ray = streams.rays[index];
    const MultipassRay<Traverser> r{ray, streams.states[index], streams.hits[index], streams.phases[index]};
    LeafObserver observer;
    goes_to = multipass_step<kKernel, Traverser>(view, r, observer);
    if (goes_to == MultipassKernel::finished) finish(index, r.hit);
  }
  append(lists, index, goes_to);
}

}  // namespace accel::cuda
