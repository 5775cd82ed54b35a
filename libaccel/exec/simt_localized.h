// The SIMT model of localized intersection with queues: packet/localized_warp.h on modelled warps.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>

#include "libaccel/exec/simt_lanes.h"
#include "libaccel/packet/localized_warp.h"

namespace accel {

// Each warp works off `rays_per_warp` tasks, a fixed share as in exec/simt.h. answers[i] answers ray i of the tasks. O(tests),
// on the calling thread. May throw std::bad_alloc.
template <class Test, Query kQuery, std::uint32_t kRaysInHand, class Answer>
WarpProfile simulate_localized(const LocalizedTasks& tasks, Answer* answers, std::uint32_t rays_per_warp) {
  WarpProfile total;
  const auto memory = std::make_unique<LocalizedMemory<kRaysInHand>>();
  for (std::uint32_t begin = 0; begin < tasks.count;) {
    const std::uint32_t end = begin + std::min(rays_per_warp, tasks.count - begin);
    SimtLanes lanes(begin, end);
    LocalizedWarp<Test, kQuery, kRaysInHand, SimtLanes, Answer>(tasks, answers, *memory, lanes).run();
    total += lanes.profile();
    begin = end;
  }
  return total;
}

}  // namespace accel
