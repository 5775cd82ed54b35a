// The lanes of a warp (packet/warp_queue.h) in the SIMT model: one after the other on the CPU, with what a warp's steps cost.
// The code that runs is the one that devices run.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "libaccel/exec/simt_profile.h"
#include "libaccel/exec/simt_traffic.h"
#include "libaccel/packet/warp_queue.h"

namespace accel {

static_assert(kLanes == kWarpSize);

// What a warp's steps cost: a step is one run of all lanes that take part. Boxes are the profile's descend, triangles its
// intersect; queues are no part of the traversal, and stand for themselves.
struct WarpProfile {
  SimtProfile simt;
  SimtProfile::PhaseSteps queues;

  SimtProfile::PhaseSteps& of(WarpStep step) {
    switch (step) {
      case WarpStep::fetch:
        return simt.fetch;
      case WarpStep::boxes:
        return simt.descend;
      case WarpStep::triangles:
        return simt.intersect;
      case WarpStep::queues:
        break;
    }
    return queues;
  }
  WarpProfile& operator+=(const WarpProfile& other) {
    simt += other.simt, queues += other.queues;
    return *this;
  }
};

class SimtLanes {
 public:
  template <class T>
  using PerLane = std::array<T, kLanes>;

  // A warp that works [begin, end) off.
  SimtLanes(std::uint32_t begin, std::uint32_t end) : next_(begin), end_(end) {
    profile_.simt.warps = 1, profile_.simt.rays = end - begin;
  }

  const WarpProfile& profile() const { return profile_; }

  template <class Body>
  void run(WarpStep step, LaneMask lanes, const Body& body) {
    if (lanes == 0) return;
    for (LaneMask left = lanes; left != 0; left &= left - 1) {
      const int lane = std::countr_zero(left);
      LaneObserver observer(requests_, nullptr, 0, lane);
      body(lane, observer);
    }
    profile_.of(step) += {1, count(lanes)};
    requests_.close(profile_.simt);
  }

  template <class Predicate>
  LaneMask where(LaneMask lanes, const Predicate& predicate) const {
    LaneMask result = 0;
    for (LaneMask left = lanes; left != 0; left &= left - 1)
      if (predicate(std::countr_zero(left))) result |= left & (~left + 1);
    return result;
  }

  static std::uint32_t count(LaneMask lanes) { return static_cast<std::uint32_t>(std::popcount(lanes)); }
  static std::uint32_t rank(LaneMask lanes, int lane) { return count(lanes & ((1u << lane) - 1)); }

  ClaimedWork claim(std::uint32_t n, std::uint32_t) {
    const ClaimedWork work{next_, std::min(n, end_ - next_)};
    next_ += work.count;
    return work;
  }

  static std::uint32_t add(std::uint32_t& word, std::uint32_t value) {
    const std::uint32_t before = word;
    word += value;
    return before;
  }
  static void write_any(std::uint32_t& word, std::uint32_t value) { word = value; }

 private:
  std::uint32_t next_, end_;
  WarpRequests requests_;
  WarpProfile profile_;
};

}  // namespace accel
