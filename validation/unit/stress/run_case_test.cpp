#include "validation/stress/run_case.h"

#include <gtest/gtest.h>

#include <set>

#include "validation/oracle/embree.h"

namespace accel::validation {
namespace {

const StressCase& case_named(std::string_view name) { return *find_cases(name).value().front(); }

StressOutcome run(std::string_view name, const StressRun& settings) {
  const Result<StressOutcome> outcome = run_case(case_named(name), settings);
  EXPECT_TRUE(outcome) << outcome.message();
  return outcome ? *outcome : StressOutcome{};
}

TEST(StressCatalogue, NamesAreUniqueAndSayWhatIsExpected) {
  std::set<std::string_view> names;
  for (const StressCase& one : stress_cases()) {
    EXPECT_TRUE(names.insert(one.name).second) << one.name;
    EXPECT_FALSE(one.what.empty() || one.expectation.empty()) << one.name;
    EXPECT_EQ(one.scenes == nullptr, one.family() == "leaks") << one.name;
  }
}

TEST(StressCatalogue, FindsCasesFamiliesAndSlips) {
  EXPECT_EQ(find_cases("laws/scale").value().size(), 1u);
  EXPECT_EQ(find_cases("laws").value().size(), 7u);
  const auto slip = find_cases("laws/scael");
  ASSERT_FALSE(slip);
  EXPECT_NE(slip.message().find("did you mean 'laws/scale'?"), std::string::npos) << slip.message();
}

TEST(StressCatalogue, ExpectsNothingWhereSinglePrecisionEnds) {
  const StressTally good{.rays = 10}, leaky{.rays = 10, .leaks = 1}, broken{.rays = 10, .broken = 1};
  for (const StressCase& one : stress_cases()) {
    EXPECT_TRUE(is_as_expected(one, good)) << one.name;
    EXPECT_EQ(is_as_expected(one, leaky), one.expected == Expected::measured) << one.name;
    EXPECT_FALSE(is_as_expected(one, broken)) << one.name;
  }
}

// The numbers are those of the seed, whatever the threads.
TEST(RunCase, DependsOnTheSeedAlone) {
  for (const char* name : {"rays/vertices", "geometry/slivers", "leaks/1"}) {
    const StressTally one = run(name, {.method = "bvh8/ordered", .rays = 3000, .threads = 1}).ours;
    EXPECT_EQ(run(name, {.method = "bvh8/ordered", .rays = 3000, .threads = 2}).ours, one) << name;
    EXPECT_GE(one.rays, 2900u) << name;
    EXPECT_GT(one.judged, 0u) << name;
  }
}

// Without a witness only so many rays are judged, and the others say nothing.
TEST(RunCase, CountsWhatItLeavesUndecided) {
  const StressTally tally = run("rays/far-away", {.method = "brute/loop", .rays = 200'000, .threads = 2}).ours;
  EXPECT_GT(tally.unjudged, 0u);
  EXPECT_EQ(tally.judged + tally.unjudged, tally.rays);
}

// The leak test must be able to see leaks: Embree's fast mode has plenty, its robust mode some, on rays where ours has none.
TEST(RunCase, SeesTheLeaksOfOthers) {
  if (!EmbreeWitness::available()) GTEST_SKIP() << EmbreeWitness::version();
  const StressOutcome outcome =
      run("leaks/0", {.method = "sbvh/stack", .rays = 60'000, .witness = StressWitness::embree, .threads = 2});
  EXPECT_EQ(outcome.ours.wrong(), 0u);
  EXPECT_EQ(outcome.robust.rays, outcome.ours.rays);
  EXPECT_GT(outcome.fast.leaks, 100u);
  EXPECT_GT(outcome.fast.leaks, outcome.robust.leaks);
}

TEST(RunCase, ReportsFailures) {
  StressCase wrong = case_named("rays/vertices");
  wrong.expected = Expected::all_misses;
  std::uint64_t reported = 0;
  const auto keep = [&](const StressFailure& failure) {
    ++reported;
    EXPECT_EQ(failure.case_name, "rays/vertices");
    EXPECT_FALSE(failure.cases.empty());
    EXPECT_GT(failure.mesh->size(), 0u);
  };
  const Result<StressOutcome> outcome = run_case(wrong, {.method = "sbvh/stack", .rays = 500, .on_failure = keep});
  ASSERT_TRUE(outcome) << outcome.message();
  EXPECT_GT(outcome->ours.false_hit, 100u);
  EXPECT_GT(reported, 0u);
  EXPECT_FALSE(is_as_expected(wrong, outcome->ours));
}

TEST(RunCase, MissesBuildErrors) {
  StressCase wrong = case_named("geometry/empty");
  wrong.expected = Expected::build_error;
  const Result<StressOutcome> outcome = run_case(wrong, {.method = "kdtree/stack"});
  ASSERT_TRUE(outcome) << outcome.message();
  EXPECT_EQ(outcome->ours.broken, 1u);
}

TEST(RunCase, CanBeInterrupted) {
  const auto stop = [](std::string_view, double) { return false; };
  for (const char* name : {"rays/vertices", "leaks/1"}) {
    const Result<StressOutcome> outcome = run_case(case_named(name), {.method = "bvh/stack", .progress = stop});
    ASSERT_FALSE(outcome) << name;
    EXPECT_EQ(outcome.message(), kInterrupted);
  }
  EXPECT_FALSE(run_case(case_named("leaks/1"), {.method = "bvh/stak"}));
}

}  // namespace
}  // namespace accel::validation
