#include "validation/compare/judge_hits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "libaccel/geometry/watertight.h"
#include "validation/oracle/brute_hits.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

// Three unit squares over one another, at z = 0, 1 and 2, of two triangles each: 0 and 1, 2 and 3, 4 and 5.
TriangleMesh squares() {
  std::vector<Triangle> triangles;
  for (const float z : {0.0f, 1.0f, 2.0f}) {
    triangles.push_back({{0, 0, z}, {1, 0, z}, {1, 1, z}});
    triangles.push_back({{0, 0, z}, {1, 1, z}, {0, 1, z}});
  }
  return mesh_of(triangles);
}

const Ray kInside{.org = {0.75f, 0.25f, -1}, .dir = {0, 0, 1}};  // through 0, 2 and 4
const Ray kDiagonal{.org = {0.5f, 0.5f, -1}, .dir = {0, 0, 1}};  // through their edges
const Ray kBoundary{.org = {0.5f, 0.0f, -1}, .dir = {0, 0, 1}};

Hit hit(float t, std::uint32_t prim_id) { return {.t = t, .prim_id = prim_id}; }

HitsVerdict judged(const Ray& ray, const std::vector<Hit>& hits) { return judge_hits(Judge(squares()), ray, hits); }

TEST(JudgeHits, ACompleteListIsRight) {
  const HitsVerdict v = judged(kInside, {hit(1, 0), hit(2, 2), hit(3, 4)});
  EXPECT_EQ(v.right, 3u);
  EXPECT_EQ(v.failures(), 0u);
}

TEST(JudgeHits, EveryHitThatIsMissingCounts) {
  EXPECT_EQ(judged(kInside, {}).miss, 1u);
  EXPECT_EQ(judged(kInside, {hit(2, 2), hit(3, 4)}).miss, 1u);
  EXPECT_EQ(judged(kInside, {hit(1, 0), hit(3, 4)}).miss, 1u) << "no other surface stands in";
  EXPECT_EQ(judged(kInside, {hit(1, 0), hit(2, 2)}).miss, 1u);
}

TEST(JudgeHits, APrefixIsCompleteInFrontOfItsEnd) {
  const Judge judge{squares()};
  EXPECT_EQ(judge_hits(judge, kInside, std::vector<Hit>{hit(1, 0), hit(2, 2)}, 2).failures(), 0u);
  EXPECT_EQ(judge_hits(judge, kInside, std::vector<Hit>{hit(2, 2)}, 2).miss, 1u);
}

TEST(JudgeHits, OneSideOfASharedEdgeWillDo) {
  for (const std::uint32_t side : {0u, 1u}) {
    const HitsVerdict v = judged(kDiagonal, {hit(1, side), hit(2, 2 + side), hit(3, 5 - side)});
    EXPECT_EQ(v.failures(), 0u);
    EXPECT_EQ(v.edge, 3u);
  }
  EXPECT_EQ(judged(kDiagonal, {hit(1, 0), hit(1, 1), hit(2, 2), hit(3, 4), hit(3, 5)}).failures(), 0u) << "so will both";
  EXPECT_EQ(judged(kDiagonal, {hit(1, 0), hit(1, 1), hit(3, 4)}).miss, 1u) << "a leak between 2 and 3";
}

TEST(JudgeHits, ABoundaryExcusesAMiss) {
  EXPECT_EQ(judged(kBoundary, {}).failures(), 0u);
  EXPECT_EQ(judged(kBoundary, {hit(2, 2)}).failures(), 0u);
}

TEST(JudgeHits, FalseHits) {
  const std::vector<Hit> all{hit(1, 0), hit(2, 2), hit(3, 4)};
  const auto with = [&](Hit extra) {
    std::vector<Hit> hits = all;
    hits.push_back(extra);
    std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return is_before(place_of(a), place_of(b)); });
    return judged(kInside, hits);
  };
  EXPECT_EQ(with(hit(1, 1)).false_hit, 1u) << "the ray passes it by";
  EXPECT_EQ(with(hit(2.5f, 2)).false_hit, 1u) << "not where the triangle is";
  EXPECT_EQ(with(hit(4, 77)).false_hit, 1u) << "no triangle";
  Ray shorter = kInside;
  shorter.t_max = 2.5f;
  EXPECT_EQ(judged(shorter, all).false_hit, 1u) << "beyond the interval";
  EXPECT_EQ(judged(shorter, {hit(1, 0), hit(2, 2)}).failures(), 0u);
}

TEST(JudgeHits, TheOrderCounts) {
  EXPECT_EQ(judged(kInside, {hit(2, 2), hit(1, 0), hit(3, 4)}).disorder, 1u);
  EXPECT_EQ(judged(kInside, {hit(1, 0), hit(1, 0), hit(2, 2), hit(3, 4)}).disorder, 1u) << "twice the same";
  EXPECT_EQ(judged(kDiagonal, {hit(1, 1), hit(1, 0), hit(2, 2), hit(3, 4)}).disorder, 1u) << "the lower number comes first";
}

// The watertight test keeps its promise for all hits, as it does for the nearest.
TEST(JudgeHits, TheWatertightTestIsClean) {
  HitsVerdict sum;
  for (const StressScene& scene : stress_scenes(91)) {
    const Judge judge(scene.mesh);
    for (const Ray& ray : stress_rays(scene.mesh, 500, 92)) {
      const HitsVerdict v = judge_hits(judge, ray, all_hits<Watertight>(scene.mesh, ray));
      EXPECT_EQ(v.failures(), 0u) << scene.name;
      sum += v;
    }
  }
  EXPECT_GT(sum.right, 1000u);
  EXPECT_GT(sum.edge, 1000u);
}

}  // namespace
}  // namespace accel::validation
