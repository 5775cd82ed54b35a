// How many threads of oneTBB a call may use.
#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>

namespace accel {

// The size of a tbb::task_arena for `threads` threads; 0: as many as the machine has. Never more than oneTBB may start, which
// is the machine's number too unless the program has raised it (tbb::global_control): asked for more, oneTBB prints a warning.
inline int arena_size(int threads) {
  if (threads <= 0) return tbb::task_arena::automatic;
  const std::size_t allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return static_cast<int>(std::min(static_cast<std::size_t>(threads), allowed));
}

}  // namespace accel
