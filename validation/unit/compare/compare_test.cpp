#include "validation/compare/compare.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libaccel/core/float_bounds.h"
#include "validation/unit/compare/test_scenes.h"

namespace accel::validation {
namespace {

// A sphere seen from inside, its right answers, and a judge.
struct Inside {
  TriangleMesh mesh = test::sphere(3);
  Judge judge{mesh};
  std::vector<Ray> rays = test::edge_rays(mesh, {0, 0, 0}, 0.5f, 5000, 1);
  std::vector<Hit> hits = test::brute_force<Watertight>(mesh, rays);
  std::vector<std::uint8_t> occluded = test::brute_force_any<Watertight>(mesh, rays);
};

CheckResult check(const Inside& s, std::span<const Hit> ours, std::span<const Hit> witness,
                  const CompareOptions& options = {}) {
  Result<CheckResult> result = compare(s.judge, s.rays, ours, witness, options);
  EXPECT_TRUE(result.ok());
  return result.ok() ? *result : CheckResult{};
}

TEST(Compare, WithoutAWitnessEveryRayIsJudged) {
  const Inside s;
  const CheckResult result = check(s, s.hits, {});
  EXPECT_EQ(result.rays, s.rays.size());
  EXPECT_FALSE(result.has_witness);
  EXPECT_EQ(result.ours.agree, 0);
  EXPECT_EQ(result.ours.judged, s.rays.size());
  EXPECT_EQ(result.ours.right + result.ours.neighbour + result.ours.edge, s.rays.size());
  EXPECT_GT(result.ours.right, s.rays.size() / 2);
  EXPECT_GT(result.ours.neighbour, 0);
  EXPECT_EQ(result.failures(), 0);
  EXPECT_EQ(result.witness.judged, 0);
  EXPECT_TRUE(result.verdicts.empty());
  EXPECT_FALSE(result.limit_binds());
}

TEST(Compare, AgreeingRaysAreSampled) {
  const Inside s;
  CompareOptions options;
  options.sample_share = 0.1;
  options.keep_verdicts = true;
  const CheckResult result = check(s, s.hits, s.hits, options);
  EXPECT_EQ(result.ours.agree, s.rays.size());
  EXPECT_NEAR(result.ours.judged, 500, 100);
  EXPECT_EQ(result.witness.judged, result.ours.judged);
  EXPECT_EQ(result.adjudication.both_right, result.ours.judged);
  EXPECT_EQ(std::count(result.verdicts.begin(), result.verdicts.end(), Verdict::agree), s.rays.size() - result.ours.judged);
  EXPECT_EQ(result.witness_verdicts, result.verdicts);
}

// Mistakes on either side, and one that both make, which only the sample can find.
TEST(Compare, AdjudicatesMistakes) {
  const Inside s;
  std::vector<Hit> ours = s.hits, theirs = s.hits;
  ours[10] = Hit{}, ours[20].t *= 1.5f, ours[30].prim_id = (ours[30].prim_id + 200) % 512;
  theirs[40] = Hit{}, theirs[41] = Hit{};
  ours[50] = Hit{}, theirs[50].t *= 0.5f;
  ours[60] = theirs[60] = Hit{};
  CompareOptions options;
  options.sample_share = 0;
  options.keep_verdicts = true;
  const CheckResult result = check(s, ours, theirs, options);
  EXPECT_EQ(result.ours.agree, s.rays.size() - 6);
  EXPECT_EQ(result.ours.judged, 6);
  EXPECT_EQ(result.ours.miss, 2);
  EXPECT_EQ(result.ours.far, 1);
  EXPECT_EQ(result.ours.false_hit, 1);
  EXPECT_EQ(result.witness.miss, 2);
  EXPECT_EQ(result.witness.false_hit, 1);
  EXPECT_EQ(result.adjudication.both_right, 0);
  EXPECT_EQ(result.adjudication.only_ours_right, 2);
  EXPECT_EQ(result.adjudication.only_witness_right, 3);
  EXPECT_EQ(result.adjudication.both_wrong, 1);
  ASSERT_EQ(result.first_failures.size(), 4);
  EXPECT_EQ(result.first_failures[0].ray, 10);
  EXPECT_EQ(result.first_failures[0].verdict, Verdict::miss);
  EXPECT_EQ(result.first_failures[3].ray, 50);
  EXPECT_EQ(result.verdicts[20], Verdict::far);
  EXPECT_EQ(result.verdicts[60], Verdict::agree);
  EXPECT_EQ(result.witness_verdicts[40], Verdict::miss);

  options.sample_share = 1;
  EXPECT_EQ(check(s, ours, theirs, options).ours.miss, 3);
}

TEST(Compare, TheLimitBindsAndSaysSo) {
  const Inside s;
  const std::vector<Hit> nothing(s.rays.size());
  CompareOptions options;
  options.max_judged = 100;
  options.keep_verdicts = true;
  const CheckResult result = check(s, nothing, s.hits, options);
  EXPECT_EQ(result.ours.judged, 100);
  EXPECT_EQ(result.unjudged, s.rays.size() - 100);
  EXPECT_TRUE(result.limit_binds());
  EXPECT_EQ(result.failures(), 100);
  EXPECT_EQ(result.first_failures.size(), options.max_failures);
  EXPECT_EQ(std::count(result.verdicts.begin(), result.verdicts.end(), Verdict::unjudged), result.unjudged);
  // Spread over the batch.
  const auto last = std::find(result.verdicts.rbegin(), result.verdicts.rend(), Verdict::miss);
  EXPECT_LT(last - result.verdicts.rbegin(), 100);

  // Where it leaves out agreeing rays only, every disagreement was judged.
  options.sample_share = 1;
  EXPECT_FALSE(check(s, s.hits, s.hits, options).limit_binds());
}

TEST(Compare, DoesNotDependOnThreads) {
  const Inside s;
  const std::vector<Hit> theirs = test::brute_force<MoellerTrumbore>(s.mesh, s.rays);
  CompareOptions options;
  options.keep_verdicts = true;
  options.threads = 1;
  const CheckResult one = check(s, s.hits, theirs, options);
  options.threads = 2;
  const CheckResult two = check(s, s.hits, theirs, options);
  EXPECT_EQ(one.verdicts, two.verdicts);
  EXPECT_EQ(one.witness_verdicts, two.witness_verdicts);
  EXPECT_EQ(one.errors.t_ulp_mean, two.errors.t_ulp_mean);
  EXPECT_EQ(one.errors.t_ulp_p99, two.errors.t_ulp_p99);
  EXPECT_EQ(one.errors.barycentric_max, two.errors.barycentric_max);
}

// The square at z = 0, rays from z = 1 along -z: t* = 1 and u, v are exact, so errors are what the test puts in.
TEST(Compare, MeasuresErrorsInUlps) {
  const Judge judge(test::square());
  const std::vector<Ray> rays(200, Ray{{0.75f, 0.25f, 1}, 0, {0, 0, -1}});
  std::vector<Hit> hits(rays.size(), Hit{1, 0.5f, 0.25f, 0});
  hits[5].t = next_up(1);
  hits[6].t = next_up(next_up(1)), hits[6].u = 0.5f + 0x1p-20f;
  const Result<CheckResult> result = compare(judge, rays, hits, {});
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->errors.samples, 200);
  EXPECT_EQ(result->errors.t_ulp_max, 2);
  EXPECT_EQ(result->errors.t_ulp_p99, 0);
  EXPECT_DOUBLE_EQ(result->errors.t_ulp_mean, 3.0 / 200);
  EXPECT_EQ(result->errors.barycentric_max, 0x1p-20);
}

TEST(Compare, AnyHit) {
  const Inside s;
  std::vector<std::uint8_t> ours = s.occluded;
  ASSERT_EQ(std::count(ours.begin(), ours.end(), 1), ours.size());
  ours[7] = ours[8] = 0;
  const Result<CheckResult> result = compare_any(s.judge, s.rays, ours, s.occluded);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->ours.agree, s.rays.size() - 2);
  EXPECT_EQ(result->ours.miss, 2);
  EXPECT_EQ(result->adjudication.only_witness_right, 2);
  EXPECT_EQ(result->first_failures[1].ray, 8);
  EXPECT_EQ(result->errors.samples, 0);

  const Result<CheckResult> alone = compare_any(s.judge, s.rays, s.occluded, {});
  ASSERT_TRUE(alone.ok());
  EXPECT_EQ(alone->ours.right, s.rays.size());
}

TEST(Compare, RefusesMismatchedSpansAndStopsWhenAsked) {
  const Inside s;
  EXPECT_FALSE(compare(s.judge, s.rays, std::span(s.hits).first(3), {}).ok());
  EXPECT_FALSE(compare(s.judge, s.rays, s.hits, std::span(s.hits).first(3)).ok());
  EXPECT_FALSE(compare_any(s.judge, s.rays, {}, s.occluded).ok());
  EXPECT_TRUE(compare(s.judge, {}, {}, {}).ok());

  // Progress is reported a few times a second, so the batch must take longer than that.
  std::vector<Ray> many;
  std::vector<Hit> hits;
  for (int i = 0; i < 60; ++i) {
    many.insert(many.end(), s.rays.begin(), s.rays.end());
    hits.insert(hits.end(), s.hits.begin(), s.hits.end());
  }
  CompareOptions options;
  options.progress = [](std::string_view phase, double share) {
    EXPECT_EQ(phase, "check");
    EXPECT_GT(share, 0);
    return false;
  };
  const Result<CheckResult> result = compare(s.judge, many, hits, {}, options);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.message(), kInterrupted);
}

TEST(Rate, RuleOfThree) {
  EXPECT_DOUBLE_EQ(rate(0, 1'000'000).per_million, 0);
  EXPECT_DOUBLE_EQ(rate(0, 1'000'000).bound95_per_million, 3);
  EXPECT_DOUBLE_EQ(rate(5, 2'000'000).per_million, 2.5);
  EXPECT_DOUBLE_EQ(rate(5, 2'000'000).bound95_per_million, 2.5);
  EXPECT_DOUBLE_EQ(rate(0, 1).bound95_per_million, 1e6) << "no more than all";
  EXPECT_TRUE(std::isnan(rate(0, 0).per_million) && std::isnan(rate(0, 0).bound95_per_million));
}

// Rays that the limit left out say nothing of how often hits are wrong.
TEST(Rate, IsOfTheRaysThatWereDecided) {
  CheckResult check;
  check.rays = 20'000, check.unjudged = 19'800;
  EXPECT_DOUBLE_EQ(check.rate_of(0).bound95_per_million, 15'000);
  EXPECT_DOUBLE_EQ(check.rate_of(1).per_million, 5'000);
  // Wrong hits are among the rays that disagree: a tenth of those, judged, has a tenth of the wrong ones.
  check.ours.agree = 19'000, check.unjudged = 900;
  EXPECT_DOUBLE_EQ(check.rate_of(1).per_million, 500);
  EXPECT_DOUBLE_EQ(check.rate_of(0).bound95_per_million, 1'500);
  check.unjudged = 1'000;
  EXPECT_TRUE(std::isnan(check.rate_of(0).per_million));
}

}  // namespace
}  // namespace accel::validation
