// What a batch of rays cost, counted rather than timed.
#pragma once

#include <cstdint>

#include "libaccel/trace/traverser.h"

namespace accel {

// Sums over rays. Every counter is exact and the same for any number of threads.
struct Counters {
  std::uint64_t rays = 0;
  std::uint64_t node_steps = 0;   // inner nodes visited on the way down
  std::uint64_t leaf_visits = 0;  // leaves reached, empty ones too
  std::uint64_t box_tests = 0;
  std::uint64_t triangle_tests = 0;
  std::uint64_t backtracks = 0;              // steps back towards postponed nodes
  std::uint64_t bytes[kMemoryClasses] = {};  // loaded and stored, by Memory class

  Counters& operator+=(const Counters& other) {
    rays += other.rays, node_steps += other.node_steps, leaf_visits += other.leaf_visits, box_tests += other.box_tests;
    triangle_tests += other.triangle_tests, backtracks += other.backtracks;
    for (int c = 0; c < kMemoryClasses; ++c) bytes[c] += other.bytes[c];
    return *this;
  }
};

// The observer that counts for one ray or for many.
struct CountingObserver {
  Counters counters;

  ACCEL_HD void load(Memory memory, const void*, std::uint32_t bytes) { counters.bytes[static_cast<int>(memory)] += bytes; }
  ACCEL_HD void store(Memory memory, const void*, std::uint32_t bytes) { counters.bytes[static_cast<int>(memory)] += bytes; }
  ACCEL_HD void node_step() { ++counters.node_steps; }
  ACCEL_HD void leaf_visit(std::uint32_t) { ++counters.leaf_visits; }
  ACCEL_HD void box_tests(std::uint32_t n) { counters.box_tests += n; }
  ACCEL_HD void triangle_test() { ++counters.triangle_tests; }
  ACCEL_HD void backtrack() { ++counters.backtracks; }
};

}  // namespace accel
