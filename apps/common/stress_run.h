// Runs `accel-trace stress`: cases and methods in rounds of more and more rays, which are large scenes' from the fourth on.
//
// A round's rays and scenes depend on the seed and the round alone, so that an interrupted run that goes on counts what one
// that was not interrupted does, and all methods trace the same.
#pragma once

#include "apps/common/progress_bar.h"
#include "apps/common/stress_options.h"
#include "apps/common/stress_state.h"

namespace accel::apps {

// Files that show what a method got wrong in a case.
struct StressBundle {
  const validation::StressCase* of;
  std::string method, text;
};

struct StressReport {
  StressState state;
  std::vector<StressBundle> bundles;  // of failures, and of what is wrong where nothing is promised

  // Pairs of a case and a method that are not as expected.
  std::uint64_t failures(const StressSettings& settings) const;
};

bool is_failure(const validation::StressCase& one, const StressEntry& entry);

Outcome<StressReport> run_stress(const StressSettings& settings, const Terminal& terminal, ProgressBar& bar);

}  // namespace accel::apps
