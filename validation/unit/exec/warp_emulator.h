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
#define __shared__ static  // of all warps: kernels that have any run on one

constexpr int warpSize = 32;

// What the lanes say in a vote or shuffle lies in two places by turns: a lane that is already at the next one does not write
// over what others still read, and one barrier a vote is enough.
struct EmulatedWarp {
  std::barrier<> barrier{warpSize};
  unsigned values[2][warpSize];
};
struct EmulatedIndex {
  unsigned x = 0;
};
inline thread_local EmulatedIndex threadIdx, blockIdx, blockDim;
inline thread_local EmulatedWarp* this_warp = nullptr;
inline thread_local unsigned this_turn = 0;

inline void __syncwarp() { this_warp->barrier.arrive_and_wait(); }

// What every lane says, once all have said it.
inline const unsigned* exchange(unsigned value) {
  unsigned* values = this_warp->values[this_turn];
  this_turn ^= 1u;
  values[threadIdx.x] = value;
  __syncwarp();
  return values;
}

inline unsigned __shfl_sync(unsigned, unsigned value, int lane) { return exchange(value)[lane]; }

inline unsigned __ballot_sync(unsigned, bool vote) {
  const unsigned* votes = exchange(vote ? 1u : 0u);
  unsigned result = 0;
  for (unsigned lane = 0; lane < warpSize; ++lane) result |= votes[lane] << lane;
  return result;
}

inline bool __any_sync(unsigned lanes, bool vote) { return __ballot_sync(lanes, vote) != 0; }
inline int __popc(unsigned bits) { return std::popcount(bits); }
inline int __ffs(int bits) { return bits == 0 ? 0 : std::countr_zero(static_cast<unsigned>(bits)) + 1; }
inline unsigned atomicAdd(unsigned* value, unsigned add) { return std::atomic_ref<unsigned>(*value).fetch_add(add); }

inline unsigned atomicExch(unsigned* value, unsigned to) { return std::atomic_ref<unsigned>(*value).exchange(to); }

// Runs kernel() in `warps` blocks of one warp each.
inline void run_warps(unsigned warps, const std::function<void()>& kernel) {
  std::vector<EmulatedWarp> state(warps);
  std::vector<std::thread> lanes;
  for (unsigned w = 0; w < warps; ++w) {
    for (unsigned lane = 0; lane < warpSize; ++lane) {
      lanes.emplace_back([&, w, lane] {
        threadIdx.x = lane, blockIdx.x = w, blockDim.x = warpSize;
        this_warp = &state[w], this_turn = 0;
        kernel();
      });
    }
  }
  for (std::thread& lane : lanes) lane.join();
}
