// The lanes of a warp (packet/warp_queue.h) on a device: each thread is one of them, and what is not PerLane is the same in
// all.
#pragma once

#include <cstdint>

#include "libaccel/exec/cuda/trace_kernel.cuh"
#include "libaccel/packet/warp_queue.h"

namespace accel::cuda {

class DeviceLanes {
 public:
  // A register.
  template <class T>
  struct PerLane {
    T value{};
    __device__ T& operator[](int) { return value; }
    __device__ const T& operator[](int) const { return value; }
  };

  // next_work is in device memory, 0 at launch, and for all warps.
  __device__ explicit DeviceLanes(std::uint32_t* next_work)
      : next_work_(next_work), lane_(static_cast<int>(threadIdx.x % warpSize)) {}

  template <class Body>
  __device__ void run(WarpStep, LaneMask lanes, const Body& body) const {
    if (lanes == 0) return;
    NullObserver observer;
    if ((lanes >> lane_ & 1u) != 0) body(lane_, observer);
    __syncwarp();
  }

  template <class Predicate>
  __device__ LaneMask where(LaneMask lanes, const Predicate& predicate) const {
    return lanes == 0 ? 0 : __ballot_sync(kAllLanes, (lanes >> lane_ & 1u) != 0 && predicate(lane_));
  }

  __device__ static std::uint32_t count(LaneMask lanes) { return static_cast<std::uint32_t>(__popc(lanes)); }
  __device__ static std::uint32_t rank(LaneMask lanes, int lane) { return count(lanes & ((1u << lane) - 1u)); }

  __device__ ClaimedWork claim(std::uint32_t n, std::uint32_t end) const {
    std::uint32_t first = 0;
    if (lane_ == 0) first = atomicAdd(next_work_, n);
    first = __shfl_sync(kAllLanes, first, 0);
    if (first >= end) return {end, 0};
    return {first, n < end - first ? n : end - first};
  }

  __device__ static std::uint32_t add(std::uint32_t& word, std::uint32_t value) { return atomicAdd(&word, value); }
  __device__ static void write_any(std::uint32_t& word, std::uint32_t value) { atomicExch(&word, value); }

 private:
  std::uint32_t* next_work_;
  int lane_;
};

}  // namespace accel::cuda
