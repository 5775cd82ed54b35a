#include "apps/common/sweep.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace accel::apps {
namespace {

constexpr std::uint64_t kRays = 1'000'000;

// A row of a sweep; speeds in nanoseconds a ray.
TraceRow row_of(const std::string& method, const std::string& test, const std::string& kind, double ns, std::uint64_t misses,
                bool promised = false) {
  TraceRow row{method, kind, kRays};
  row.speed = {1e3 / ns, 1e3 / ns, 1e3 / ns};
  row.test = test, row.promised = promised;
  validation::CheckResult check;
  check.rays = kRays;
  check.ours.miss = misses;
  row.check = check;
  return row;
}

TraceRow embree_row(const std::string& kind, double ns, std::uint64_t misses) {
  TraceRow row = row_of("Embree", "", kind, ns, misses);
  row.embree = &kEmbreeModes[0];
  return row;
}

// Primary rays see no errors; edge rays see those of two tests.
TraceReport report() {
  TraceReport report;
  report.triangles = 100;
  report.structures.push_back({"bvh8"});
  for (const char* kind : {"primary", "edge"}) {
    const bool edge = std::string(kind) == "edge";
    report.rows.push_back(row_of("bvh8/ordered", "watertight", kind, 100, 0, true));
    report.rows.push_back(row_of("sbvh/stack", "watertight", kind, 200, 0, true));
    report.rows.push_back(row_of("bvh8/ordered", "woop", kind, 90, edge ? 20 : 0));
    report.rows.push_back(row_of("bvh8/ordered", "moeller-trumbore", kind, 80, edge ? 3000 : 1));
    report.rows.push_back(row_of("sbvh/stack", "moeller-trumbore", kind, 150, edge ? 3000 : 1));
    report.rows.push_back(embree_row(kind, 70, edge ? 500 : 0));
  }
  return report;
}

TraceSettings settings(std::optional<double> max_error = {}) {
  TraceSettings settings;
  settings.sweep = true, settings.max_error = max_error;
  settings.ray_kinds = {"primary", "edge"};
  return settings;
}

std::vector<std::string> front_of(const TraceReport& report, const std::string& kind) {
  std::vector<std::string> names;
  for (const TraceRow& row : report.rows)
    if (row.rays_kind == kind && row.point && row.point->on_front) names.push_back(row.configuration());
  std::sort(names.begin(), names.end());
  return names;
}

TEST(Sweep, TheFrontIsWhatNothingOfOursDominates) {
  TraceReport swept = report();
  place_on_plane(swept, settings());
  const std::vector<std::string> expected{"bvh8/ordered", "bvh8/ordered + moeller-trumbore", "bvh8/ordered + woop"};
  EXPECT_EQ(front_of(swept, "primary"), expected) << "Embree's error does not count, nor its speed";
  EXPECT_EQ(front_of(swept, "edge"), expected);
}

// An error that only edge rays find is one of primary rays' configurations, too.
TEST(Sweep, ErrorsAreTheWorseOfTwoKinds) {
  TraceReport swept = report();
  place_on_plane(swept, settings());
  const auto point = [&](const std::string& configuration) {
    for (const TraceRow& row : swept.rows)
      if (row.rays_kind == "primary" && row.configuration() == configuration) return *row.point;
    return SweepPoint{};
  };
  EXPECT_DOUBLE_EQ(point("bvh8/ordered + moeller-trumbore").error.per_million, 3000);
  EXPECT_DOUBLE_EQ(point("bvh8/ordered + woop").error.per_million, 20);
  EXPECT_DOUBLE_EQ(point("bvh8/ordered + woop").leaks.per_million, 20);
  EXPECT_DOUBLE_EQ(point("bvh8/ordered").error.per_million, 0);
  EXPECT_DOUBLE_EQ(point("bvh8/ordered").error.bound95_per_million, 3);
  EXPECT_DOUBLE_EQ(point("bvh8/ordered").ns_per_ray, 100);
}

std::string advice(std::optional<double> max_error, TraceReport swept = report()) {
  place_on_plane(swept, settings(max_error));
  return swept.advice.front().text;
}

TEST(Sweep, AdviceIsTheFastestThatIsPromisedOrWithinTheBound) {
  EXPECT_TRUE(advice({}).starts_with("for this scene and primary rays, use bvh8/ordered: 100 ns")) << advice({});
  EXPECT_NE(advice({}).find("bvh8/ordered + moeller-trumbore is 25 % faster, with 3000 wrong hits per million"),
            std::string::npos)
      << advice({});
  EXPECT_NE(advice(19).find("use bvh8/ordered:"), std::string::npos);
  EXPECT_NE(advice(20).find("use bvh8/ordered + woop:"), std::string::npos);
  EXPECT_NE(advice(3000).find("use bvh8/ordered + moeller-trumbore:"), std::string::npos);
  EXPECT_NE(advice(3000).find("nothing that was tried is faster"), std::string::npos);
}

// Without a wrong hit in a million rays the error may still be 3 per million: a bound below that takes a promise.
TEST(Sweep, NoErrorFoundIsNoPromise) {
  TraceReport swept = report();
  swept.rows.push_back(row_of("grid/dda", "woop", "primary", 10, 0));
  swept.rows.push_back(row_of("grid/dda", "woop", "edge", 10, 0));
  EXPECT_NE(advice(2.9, swept).find("use bvh8/ordered:"), std::string::npos);
  EXPECT_NE(advice(3, swept).find("use grid/dda + woop:"), std::string::npos);
}

TEST(Sweep, NothingMayBeGoodEnough) {
  TraceReport swept = report();
  std::erase_if(swept.rows, [](const TraceRow& row) { return row.promised; });
  EXPECT_NE(advice(1, swept).find("nothing that was tried"), std::string::npos);
}

TEST(Sweep, OnlyPromisesAreFailures) {
  TraceReport swept = report();
  EXPECT_EQ(swept.failures(), 0u);
  swept.rows.front().check->ours.miss = 2;
  EXPECT_EQ(swept.failures(), 2u);
}

}  // namespace
}  // namespace accel::apps
