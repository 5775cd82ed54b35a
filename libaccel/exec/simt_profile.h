// The figures of the SIMT model: what a batch of rays costs on a machine that runs 32 rays in lockstep. See exec/simt.h.
#pragma once

#include <cstdint>

#include "libaccel/trace/traverser.h"

namespace accel {

inline constexpr int kWarpSize = 32;

// Which loop structure drives the lanes of a warp (Aila and Laine 2009, section 3), and whether lanes that have finished fetch
// new rays (section 3.3).
enum class SimtSchedule : std::uint8_t { while_while, if_if, speculative_while_while, persistent_while_while };

struct SimtOptions {
  SimtSchedule schedule = SimtSchedule::while_while;
};

// Sums over all warps. A step is one instruction of the model: one phase function, run for all lanes that are in its phase.
struct SimtProfile {
  std::uint64_t rays = 0;
  std::uint64_t warps = 0;

  struct PhaseSteps {
    std::uint64_t steps = 0;         // times that the warp issued the phase
    std::uint64_t active_lanes = 0;  // lanes that took part, summed over the steps

    // Sum of active lanes over 32 times the steps; 1 where the phase never ran.
    double efficiency() const {
      return steps == 0 ? 1.0 : static_cast<double>(active_lanes) / (static_cast<double>(kWarpSize) * static_cast<double>(steps));
    }
  };
  PhaseSteps descend, intersect, backtrack;

  struct Traffic {
    std::uint64_t requests = 0;  // warp-wide loads and stores
    std::uint64_t lines = 0;     // distinct 128-byte lines, summed over requests
    std::uint64_t sectors = 0;   // distinct 32-byte sectors, summed over requests
    std::uint64_t bytes = 0;     // asked for by the lanes
  };
  Traffic traffic[kMemoryClasses];  // by Memory class

  // Over all phases.
  double efficiency() const {
    const std::uint64_t steps = descend.steps + intersect.steps + backtrack.steps;
    const std::uint64_t active = descend.active_lanes + intersect.active_lanes + backtrack.active_lanes;
    return PhaseSteps{steps, active}.efficiency();
  }
};

}  // namespace accel
