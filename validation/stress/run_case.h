// Runs one case of the stress catalogue for one method, and counts what went wrong.
//
// Answers are compared with a witness's (Embree's, or brute force's for small scenes); where they differ, and in a seeded
// sample, exact arithmetic judges (compare/compare.h). Of leaks it judges all that a closed mesh does not explain: leaks.h. The
// same case, method, number of rays and seed give the same numbers, whatever the threads.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "libaccel/core/progress.h"
#include "validation/compare/repro.h"
#include "validation/stress/catalogue.h"

namespace accel::validation {

// What an engine got wrong. A ray that leaks counts as a miss or as far, too, where it is judged so.
struct StressTally {
  std::uint64_t rays = 0;
  std::uint64_t leaks = 0;  // through closed meshes: from inside without a hit, or from outside to the back or through it
  std::uint64_t miss = 0, far = 0, false_hit = 0;  // judged
  std::uint64_t broken = 0;                        // laws, any-hit queries that disagree, builds beyond their budget
  std::uint64_t judged = 0, unjudged = 0;          // what a limit left undecided is `unjudged`

  std::uint64_t wrong() const { return leaks + miss + far + false_hit + broken; }
  StressTally& operator+=(const StressTally& other);
  bool operator==(const StressTally&) const = default;
};

// Whether the tally of a method is what the case wants.
bool is_as_expected(const StressCase& one, const StressTally& tally);

// Something wrong, with all that it takes to look at it again.
struct StressFailure {
  std::string_view case_name;
  std::string scene, what;
  const TriangleMesh* mesh;      // while it is reported
  std::vector<ReproCase> cases;  // none where the failure is one of the build
};

enum class StressWitness : std::uint8_t { brute_force, embree };

struct StressRun {
  std::string method;
  std::uint64_t rays = 1000;  // about, in all scenes of the case together
  std::uint64_t seed = 1;
  SceneSize size = SceneSize::small;
  StressWitness witness = StressWitness::brute_force;
  int threads = 1;
  Progress progress;
  std::function<void(const StressFailure&)> on_failure;
};

struct StressOutcome {
  StressTally ours;
  StressTally robust, fast;  // Embree's, where it was asked: robust is the witness; fast takes part in leaks alone
};

// Errors: "interrupted", a build that fails and should not, Embree.
Result<StressOutcome> run_case(const StressCase& one, const StressRun& run);

}  // namespace accel::validation
