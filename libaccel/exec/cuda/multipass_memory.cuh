// Device memory for the rays in flight of the multipass executor, without their types.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "libaccel/exec/cuda/device_memory.cuh"
#include "libaccel/exec/multipass_profile.h"
#include "libaccel/trace/traverser.h"

namespace accel::cuda {

// What a ray of some traverser takes.
struct RaySizes {
  std::size_t state = 0, stack = 0;  // no stack: 0

  std::size_t total() const { return state + stack + sizeof(Phase) + (kMultipassKernels + 1) * sizeof(std::uint32_t); }
};

struct MultipassMemory {
  std::uint32_t capacity = 0;  // rays
  DeviceArray<std::byte> states, stacks;
  DeviceArray<Phase> phases;
  DeviceArray<std::uint32_t> lists;  // one for each kernel, and the spare one
  DeviceArray<std::uint32_t> sizes;  // of the kernels' lists

  // For at most `rays` rays: fewer if they would take more than half of the memory that is free.
  static Result<MultipassMemory> allocate(std::uint32_t rays, const RaySizes& ray) {
    std::size_t free = 0, all = 0;
    ACCEL_CUDA_TRY(cudaMemGetInfo(&free, &all));
    Result<MultipassMemory> result = MultipassMemory();
    MultipassMemory& memory = *result;
    memory.capacity = static_cast<std::uint32_t>(std::clamp<std::size_t>(free / 2 / ray.total(), 1, std::max(rays, 1u)));
    const std::size_t capacity = memory.capacity;
    auto states = DeviceArray<std::byte>::allocate(capacity * ray.state);
    auto stacks = DeviceArray<std::byte>::allocate(capacity * ray.stack);
    auto phases = DeviceArray<Phase>::allocate(capacity);
    auto lists = DeviceArray<std::uint32_t>::allocate(capacity * (kMultipassKernels + 1));
    auto sizes = DeviceArray<std::uint32_t>::allocate(kMultipassKernels);
    if (!states) return states.error();
    if (!stacks) return stacks.error();
    if (!phases) return phases.error();
    if (!lists) return lists.error();
    if (!sizes) return sizes.error();
    memory.states = std::move(*states), memory.stacks = std::move(*stacks), memory.phases = std::move(*phases);
    memory.lists = std::move(*lists), memory.sizes = std::move(*sizes);
    return result;
  }
};

}  // namespace accel::cuda
