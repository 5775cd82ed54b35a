// The kernel of every traverser: the while-while loop of Aila and Laine 2009, "Understanding the Efficiency of Ray Traversal on
// GPUs" [AL09], over the state machine of trace/traverser.h.
//
//   fetch rays, for the lanes that have none
//   do
//     while a lane looks for a leaf: to the next node     lanes that have found one wait
//     while a lane has triangles: test one                lanes that have none wait
//   until enough lanes are done
//
// The lanes of a warp come together at the edges of both inner loops (__syncwarp), so that an iteration runs one phase for as
// many lanes as are in it, which the paper could take for granted and which machines with independent thread scheduling must be
// told.
//
// How rays meet threads is a policy (Work):
//   GridWork        one thread a ray; a warp ends with its slowest lane
//   PersistentWork  as many warps as the device can hold, each for as long as there are rays ([AL09] section 3.3). Lanes
//                   without work fetch rays once fewer than kFetchBelow lanes are at work (Aila, Laine and Karras 2012,
//                   dynamic fetch): one atomic a warp, votes tell each lane its ray
//
// Rays, hits and structure are read and written with 16-byte accesses. The traversal stack is the only local memory,
// interleaved by lane in hardware. exec/simt.h models this kernel: its schedules while_while and persistent_while_while are
// these policies.
#pragma once

#include <cstdint>

#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/trace/traverser.h"

namespace accel::cuda {

inline constexpr unsigned kAllLanes = 0xffffffffu;
inline constexpr std::uint32_t kNoRay = 0xffffffffu;

// Four warps a block: small enough that the last warp of a block holds back little, and a multiple of the four schedulers of a
// multiprocessor. Eight blocks a multiprocessor leave 64 registers a thread, which is what the kernels need without spilling.
inline constexpr int kBlockSize = 128;
inline constexpr int kBlocksPerMultiprocessor = 8;

// PersistentWork: lanes at work below which the others fetch. 20 is the value of the kernels of Aila, Laine and Karras 2012.
inline constexpr int kFetchBelow = 20;

__device__ inline int lanes_where(bool condition) { return __popc(__ballot_sync(kAllLanes, condition)); }

struct GridWork {
  std::uint32_t ray_count;

  // Gives idle lanes a ray, or kNoRay. False, for the whole warp, when there was none to give.
  __device__ bool fetch(bool, std::uint32_t& ray) {
    if (fetched) return false;
    fetched = true;
    const std::uint32_t thread = blockIdx.x * blockDim.x + threadIdx.x;
    ray = thread < ray_count ? thread : kNoRay;
    return true;
  }

  // Whether the warp should stop and fetch.
  __device__ bool wants_rays(bool at_work) const { return !__any_sync(kAllLanes, at_work); }

  bool fetched = false;
};

struct PersistentWork {
  std::uint32_t ray_count;
  std::uint32_t* next_ray;  // in device memory; 0 at launch

  __device__ bool fetch(bool idle, std::uint32_t& ray) {
    if (exhausted) return __any_sync(kAllLanes, !idle);
    const unsigned idle_lanes = __ballot_sync(kAllLanes, idle);
    const int lane = static_cast<int>(threadIdx.x % warpSize);
    const int leader = __ffs(static_cast<int>(idle_lanes)) - 1;
    std::uint32_t first = 0;
    if (lane == leader) first = atomicAdd(next_ray, static_cast<std::uint32_t>(__popc(idle_lanes)));
    first = __shfl_sync(kAllLanes, first, leader);
    exhausted = first + __popc(idle_lanes) >= ray_count;
    const unsigned lanes_below = (1u << lane) - 1u;
    const std::uint32_t mine = first + __popc(idle_lanes & lanes_below);
    if (idle) ray = mine < ray_count ? mine : kNoRay;
    return first < ray_count || __any_sync(kAllLanes, !idle);
  }

  __device__ bool wants_rays(bool at_work) const { return lanes_where(at_work) < (exhausted ? 1 : kFetchBelow); }

  bool exhausted = false;  // the same in all lanes
};

// Where answers go.
struct StoreHits {
  Hit* hits;
  __device__ void operator()(std::uint32_t ray, const Hit& hit) const { hits[ray] = hit; }
};
struct StoreOccluded {
  std::uint8_t* occluded;
  __device__ void operator()(std::uint32_t ray, const Hit& hit) const { occluded[ray] = hit.valid() ? 1 : 0; }
  StoreOccluded from(std::uint32_t first_ray) const { return {occluded + first_ray}; }  // for the rays from there on
};

// For rays that are a selection of others: ids[i] is where the answer to ray i goes.
template <class Store>
struct StoreListed {
  const std::uint32_t* ids;
  Store store;
  __device__ void operator()(std::uint32_t ray, const Hit& hit) const { store(ids[ray], hit); }
};

template <class Traverser, class Work, class Store>
__global__ void __launch_bounds__(kBlockSize, kBlocksPerMultiprocessor)
    trace_kernel(const typename Traverser::View view, const Ray* __restrict__ rays, Work work, const Store store) {
  StackOf<Traverser> stack;
  typename Traverser::State state{};
  attach_stack<Traverser>(state, stack);
  NullObserver observer;
  Ray ray;
  Hit hit;
  std::uint32_t index = kNoRay;
  Phase phase = Phase::done;

  while (work.fetch(index == kNoRay, index)) {
    if (index != kNoRay && phase == Phase::done) {
      ray = rays[index];
      phase = Traverser::begin(view, ray, state, hit, observer);
    }
    do {
      while (phase == Phase::descend || phase == Phase::backtrack) {
        if (phase == Phase::descend) phase = Traverser::descend(view, ray, state, hit, observer);
        if (phase == Phase::backtrack) phase = Traverser::backtrack(view, ray, state, hit, observer);
      }
      __syncwarp();
      while (phase == Phase::intersect) phase = Traverser::intersect(view, ray, state, hit, observer);
      __syncwarp();
    } while (!work.wants_rays(phase != Phase::done));
    if (index != kNoRay && phase == Phase::done) {
      finish_hit(hit);
      store(index, hit);
      index = kNoRay;
    }
  }
}

}  // namespace accel::cuda
