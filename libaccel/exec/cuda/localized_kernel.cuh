// The kernel of localized intersection: packet/localized_warp.h, which exec/simt_localized.h models. Its warps are persistent:
// as many as the device can hold, each for as long as there are rays.
#pragma once

#include <cstdint>

#include "libaccel/exec/cuda/device_lanes.cuh"
#include "libaccel/packet/localized_warp.h"

namespace accel::cuda {

// next_task is in device memory, 0 at launch. Shared memory: 40 KB a block, within what every device has.
template <class Test, Query kQuery, class Answer>
__global__ void __launch_bounds__(kBlockSize)
    localized_kernel(const LocalizedTasks tasks, Answer* answers, std::uint32_t* next_task) {
  using Memory = LocalizedMemory<kLocalizedRaysInHand>;
  alignas(Memory) __shared__ unsigned char bytes[kBlockSize / static_cast<int>(kLanes) * sizeof(Memory)];
  Memory& memory = reinterpret_cast<Memory*>(bytes)[threadIdx.x / warpSize];
  DeviceLanes lanes(next_task);
  LocalizedWarp<Test, kQuery, kLocalizedRaysInHand, DeviceLanes, Answer>(tasks, answers, memory, lanes).run();
}

}  // namespace accel::cuda
