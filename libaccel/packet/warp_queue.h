// Queues of a warp: what its lanes append, and take again when a lane needs work. Lanes agree by votes on who takes which entry
// (stream compaction by ballot and prefix count), so that no atomic is needed.
//
// Code for warps is written once against Lanes, and runs lane after lane in the SIMT model (exec/simt_lanes.h) and at once on
// devices (exec/cuda/device_lanes.cuh). A Lanes has
//
//   PerLane<T>                  one T for each lane, by lane: a register on devices
//   run(step, lanes, body)      body(lane, observer) for these lanes; what it has written, all lanes see afterwards. Bodies of
//                               one run do not see each other's writes, but for add() and write_any()
//   where(lanes, predicate)     which of these lanes predicate(lane) holds for
//   count(lanes), rank(lanes, lane)   how many; how many of them come before this one
//   claim(n, count)             the next work for the warp, of [0, count): n items, or as many as are left
//   add(word, value)            adds atomically, and returns what was there before
//   write_any(word, value)      of several lanes that write the same word, any one wins
//
// What is not PerLane is the same in all lanes: sizes of queues, masks of lanes, and the way through the code.
#pragma once

#include <cstdint>

#include "libaccel/core/hd.h"

namespace accel {

inline constexpr std::uint32_t kLanes = 32;
using LaneMask = std::uint32_t;  // bit l: lane l
inline constexpr LaneMask kEveryLane = 0xffffffffu;

// What a run is to the profile. Queues are the price of lanes at work: a few instructions each, where a test has dozens.
enum class WarpStep : std::uint8_t { fetch, boxes, triangles, queues };
inline constexpr int kWarpSteps = 4;

struct ClaimedWork {
  std::uint32_t first, count;
};

// A ring in memory that the warp shares. First in, first out; whoever pushes knows that there is room.
template <class T, std::uint32_t kCapacity>
class WarpQueue {
  static_assert((kCapacity & (kCapacity - 1)) == 0, "a power of two");

 public:
  ACCEL_HD explicit WarpQueue(T* entries) : entries_(entries) {}

  ACCEL_HD std::uint32_t size() const { return size_; }

  // Appends value(lane, observer) for each of the lanes.
  template <class Lanes, class Value>
  ACCEL_HD void push(Lanes& warp, LaneMask lanes, const Value& value) {
    ACCEL_ASSERT(size_ + warp.count(lanes) <= kCapacity);
    warp.run(WarpStep::queues, lanes,
             [&](int lane, auto& observer) { at(size_ + warp.rank(lanes, lane)) = value(lane, observer); });
    size_ += warp.count(lanes);
  }

  // give(lane, entry, observer) for the lanes, the lowest first, as long as there are entries. Returns the lanes that have got
  // one.
  template <class Lanes, class Give>
  ACCEL_HD LaneMask take(Lanes& warp, LaneMask lanes, const Give& give) {
    const LaneMask served = warp.where(lanes, [&](int lane) { return warp.rank(lanes, lane) < size_; });
    warp.run(WarpStep::queues, served, [&](int lane, auto& observer) { give(lane, at(warp.rank(lanes, lane)), observer); });
    first_ += warp.count(served), size_ -= warp.count(served);
    return served;
  }

 private:
  ACCEL_HD T& at(std::uint32_t i) { return entries_[(first_ + i) % kCapacity]; }

  T* entries_;
  std::uint32_t first_ = 0, size_ = 0;
};

}  // namespace accel
