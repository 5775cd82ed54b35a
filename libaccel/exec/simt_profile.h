// The figures of the SIMT model: what a batch of rays costs on a machine that runs 32 rays in lockstep. See exec/simt.h.
#pragma once

#include <cstdint>

#include "libaccel/trace/traverser.h"

namespace accel {

inline constexpr int kWarpSize = 32;

// Which loop structure drives the lanes of a warp (Aila and Laine 2009, section 3), and whether lanes that have finished fetch
// new rays (section 3.3).
enum class SimtSchedule : std::uint8_t { while_while, if_if, speculative_while_while, persistent_while_while, if_while };
inline constexpr int kSimtSchedules = 5;

// "while-while", "if-if", ...
constexpr const char* schedule_name(SimtSchedule schedule) {
  constexpr const char* kNames[kSimtSchedules] = {"while-while", "if-if", "speculative-while-while", "persistent-while-while",
                                                  "if-while"};
  return kNames[static_cast<int>(schedule)];
}

struct SimtOptions {
  SimtSchedule schedule = SimtSchedule::while_while;

  // For persistent_while_while. The rays that one warp works off: fixed, so that the figures do not depend on who is fastest.
  std::uint32_t rays_per_warp = 1024;
  // Lanes without work fetch rays when fewer lanes than this are at work, as in the kernels of Aila, Laine and Karras 2012.
  std::uint32_t fetch_below = 20;
};

// Sums over all warps. A step is one instruction of the model: one phase function, run for all lanes that are in its phase.
struct SimtProfile {
  std::uint64_t rays = 0;
  std::uint64_t warps = 0;
  std::uint64_t postponed_leaves = 0;  // by speculation; 0 for traversers that cannot speculate (trace/traverser.h)

  struct PhaseSteps {
    std::uint64_t steps = 0;         // times that the warp issued the phase
    std::uint64_t active_lanes = 0;  // lanes that took part, summed over the steps

    // Sum of active lanes over 32 times the steps; 1 where the phase never ran.
    double efficiency() const {
      return steps == 0 ? 1.0
                        : static_cast<double>(active_lanes) / (static_cast<double>(kWarpSize) * static_cast<double>(steps));
    }
    PhaseSteps& operator+=(const PhaseSteps& other) {
      steps += other.steps, active_lanes += other.active_lanes;
      return *this;
    }
  };
  PhaseSteps descend, intersect, backtrack;
  PhaseSteps fetch;  // begin(), for the lanes that start a ray together

  struct Traffic {
    std::uint64_t requests = 0;  // warp-wide loads and stores
    std::uint64_t lines = 0;     // distinct 128-byte lines, summed over requests
    std::uint64_t sectors = 0;   // distinct 32-byte sectors, summed over requests
    std::uint64_t bytes = 0;     // asked for by the lanes

    Traffic& operator+=(const Traffic& other) {
      requests += other.requests, lines += other.lines, sectors += other.sectors, bytes += other.bytes;
      return *this;
    }
  };
  Traffic traffic[kMemoryClasses];  // by Memory class

  // Over the phases of the traversal: all but fetch.
  double efficiency() const {
    const std::uint64_t steps = descend.steps + intersect.steps + backtrack.steps;
    const std::uint64_t active = descend.active_lanes + intersect.active_lanes + backtrack.active_lanes;
    return PhaseSteps{steps, active}.efficiency();
  }

  const Traffic& of(Memory memory) const { return traffic[static_cast<int>(memory)]; }

  double bytes_per_ray(Memory memory) const {
    return rays == 0 ? 0.0 : static_cast<double>(of(memory).bytes) / static_cast<double>(rays);
  }

  SimtProfile& operator+=(const SimtProfile& other) {
    rays += other.rays, warps += other.warps, postponed_leaves += other.postponed_leaves;
    descend += other.descend, intersect += other.intersect, backtrack += other.backtrack, fetch += other.fetch;
    for (int c = 0; c < kMemoryClasses; ++c) traffic[c] += other.traffic[c];
    return *this;
  }
};

}  // namespace accel
