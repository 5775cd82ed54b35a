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

  // Nodes visited and triangles tested.
  constexpr std::uint64_t steps() const { return node_steps + triangle_tests; }

  Counters& operator+=(const Counters& other) {
    rays += other.rays, node_steps += other.node_steps, leaf_visits += other.leaf_visits, box_tests += other.box_tests;
    triangle_tests += other.triangle_tests, backtracks += other.backtracks;
    for (int c = 0; c < kMemoryClasses; ++c) bytes[c] += other.bytes[c];
    return *this;
  }
};

// What can be told of single rays.
enum class RayCounter : std::uint8_t { steps, down, up, leaves, triangles, boxes };
inline constexpr int kRayCounters = 6;

// "steps", "down", ...
constexpr const char* counter_name(RayCounter counter) {
  constexpr const char* kNames[kRayCounters] = {"steps", "down", "up", "leaves", "triangles", "boxes"};
  return kNames[static_cast<int>(counter)];
}

// What it counts, for the legend of a picture.
constexpr const char* counter_unit(RayCounter counter) {
  constexpr const char* kUnits[kRayCounters] = {"steps", "steps down", "steps back", "leaves", "triangle tests", "box tests"};
  return kUnits[static_cast<int>(counter)];
}

constexpr std::uint64_t value_of(const Counters& counters, RayCounter counter) {
  switch (counter) {
    case RayCounter::down:
      return counters.node_steps;
    case RayCounter::up:
      return counters.backtracks;
    case RayCounter::leaves:
      return counters.leaf_visits;
    case RayCounter::triangles:
      return counters.triangle_tests;
    case RayCounter::boxes:
      return counters.box_tests;
    case RayCounter::steps:
      break;
  }
  return counters.steps();
}

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
