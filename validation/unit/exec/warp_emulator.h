// The CUDA intrinsics that exec/cuda/trace_kernel.cuh uses, on the CPU: one thread a lane, a barrier a vote.
//
// With it the kernel's own source runs, and is tested, on machines without a device. Include it before the kernel. A vote that
// not all lanes of a warp take part in blocks for ever, as it would be undefined on a device.
#pragma once

#include <atomic>
#include <barrier>
#include <bit>
#include <functional>
#include <thread>
#include <vector>

#define __device__
#define __global__
#define __launch_bounds__(...)

constexpr int warpSize = 32;

struct EmulatedWarp {
  std::barrier<> barrier{warpSize};
  unsigned values[warpSize];  // what the lanes say in a vote or shuffle
};
struct EmulatedIndex {
  unsigned x = 0;
};
inline thread_local EmulatedIndex threadIdx, blockIdx, blockDim;
inline thread_local EmulatedWarp* this_warp = nullptr;

inline void __syncwarp() { this_warp->barrier.arrive_and_wait(); }

inline unsigned __shfl_sync(unsigned, unsigned value, int lane) {
  this_warp->values[threadIdx.x] = value;
  __syncwarp();
  const unsigned result = this_warp->values[lane];
  __syncwarp();
  return result;
}

inline unsigned __ballot_sync(unsigned, bool vote) {
  this_warp->values[threadIdx.x] = vote ? 1u : 0u;
  __syncwarp();
  unsigned result = 0;
  for (unsigned lane = 0; lane < warpSize; ++lane) result |= this_warp->values[lane] << lane;
  __syncwarp();
  return result;
}

inline bool __any_sync(unsigned lanes, bool vote) { return __ballot_sync(lanes, vote) != 0; }
inline int __popc(unsigned bits) { return std::popcount(bits); }
inline int __ffs(int bits) { return bits == 0 ? 0 : std::countr_zero(static_cast<unsigned>(bits)) + 1; }
inline unsigned atomicAdd(unsigned* value, unsigned add) { return std::atomic_ref<unsigned>(*value).fetch_add(add); }

// Runs kernel() in `warps` blocks of one warp each.
inline void run_warps(unsigned warps, const std::function<void()>& kernel) {
  std::vector<EmulatedWarp> state(warps);
  std::vector<std::thread> lanes;
  for (unsigned w = 0; w < warps; ++w) {
    for (unsigned lane = 0; lane < warpSize; ++lane) {
      lanes.emplace_back([&, w, lane] {
        threadIdx.x = lane, blockIdx.x = w, blockDim.x = warpSize;
        this_warp = &state[w];
        kernel();
      });
    }
  }
  for (std::thread& lane : lanes) lane.join();
}
