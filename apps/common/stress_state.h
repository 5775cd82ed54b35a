// How far a stress run has come: what was counted for each case and engine. Kept in a file, so that an interrupted run goes on.
//
// The file is JSON, written whole or not at all. Engines are methods, and "Embree robust" and "Embree fast".
#pragma once

#include <map>
#include <string>
#include <utility>

#include "apps/common/failure.h"
#include "validation/stress/run_case.h"

namespace accel::apps {

inline constexpr const char* kEmbreeRobust = "Embree robust";
inline constexpr const char* kEmbreeFast = "Embree fast";

struct StressEntry {
  std::uint64_t rounds = 0;  // done
  std::uint64_t asked = 0;   // rays that the rounds were to trace; scenes may have had room for fewer
  validation::StressTally tally;
  std::string error;  // the first failure that is none of rays: of a build, say
};

struct StressState {
  std::uint64_t seed = 1;
  double seconds = 0;                                                  // of work, in all runs
  std::map<std::pair<std::string, std::string>, StressEntry> entries;  // by case and engine
};

// The state in a file; a new one where there is no file. Errors: a file that is no state, or one of another seed.
Outcome<StressState> load_stress_state(const std::string& path, std::uint64_t seed);

Finished save_stress_state(const std::string& path, const StressState& state);

}  // namespace accel::apps
