// The stress suite (validation/stress/catalogue.h) for every method: a few rays of each case. `accel-trace stress` runs it with
// many.
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "libaccel/registry/any_accel.h"
#include "validation/stress/run_case.h"

namespace accel::validation {
namespace {

// A family of cases and a method: the watertight test alone, since Moeller and Trumbore's promises nothing that these ask.
class StressSuite : public testing::TestWithParam<std::string> {
 protected:
  static void expect_family(const std::string& family, std::uint64_t rays) {
    const auto cases = find_cases(family);
    ASSERT_TRUE(cases) << cases.message();
    for (const StressCase* one : *cases) {
      const auto describe = [](const StressFailure& failure) {
        ADD_FAILURE() << failure.case_name << ", " << failure.scene << ": " << failure.what << first_case(failure);
      };
      const Result<StressOutcome> outcome = run_case(*one, {.method = GetParam(), .rays = rays, .on_failure = describe});
      ASSERT_TRUE(outcome) << one->name << ": " << outcome.message();
      EXPECT_GT(outcome->ours.rays, 0u) << one->name;
      const StressTally& tally = outcome->ours;
      EXPECT_TRUE(is_as_expected(*one, tally))
          << one->name << " expects " << one->expectation << ": " << tally.leaks << " leaks, " << tally.miss << " misses, "
          << tally.far << " far, " << tally.false_hit << " false, " << tally.broken << " broken of " << tally.rays;
    }
  }

 private:
  static std::string first_case(const StressFailure& failure) {
    if (failure.cases.empty()) return {};
    const ReproCase& one = failure.cases.front();
    const auto point = [](Vec3 v) { return testing::PrintToString(std::array{v.x, v.y, v.z}); };
    const auto answer = [](const Hit& hit) {
      return hit.valid() ? "triangle " + std::to_string(hit.prim_id) + " at " + testing::PrintToString(hit.t) : "a miss";
    };
    return ": " + std::string(to_string(one.verdict)) + " of ray " + std::to_string(one.ray_number) + " from " +
           point(one.ray.org) + " along " + point(one.ray.dir) + ", " + answer(one.ours) +
           (one.witness ? ", where the witness has " + answer(*one.witness) : "");
  }
};

TEST_P(StressSuite, Rays) { expect_family("rays", 400); }
TEST_P(StressSuite, Geometry) { expect_family("geometry", 400); }
TEST_P(StressSuite, Leaks) { expect_family("leaks", 1200); }

std::vector<std::string> robust_methods() {
  std::vector<std::string> names;
  for (const MethodInfo& m : methods())
    if (m.robust) names.push_back(m.name);
  return names;
}
std::string method_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  for (char& c : name)
    if (c == '/' || c == '-') c = '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Methods, StressSuite, testing::ValuesIn(robust_methods()), method_name);

}  // namespace
}  // namespace accel::validation
