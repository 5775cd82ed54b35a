// The exact oracle and the judge on instances: exactness of placed triangles, and bounds that excuse rounding and nothing else.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "libaccel/core/float_bounds.h"
#include "libaccel/geometry/watertight.h"
#include "validation/compare/judge.h"
#include "validation/oracle/brute_instances.h"
#include "validation/stress/stress_instances.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

InstancedMeshes made(std::vector<TriangleMesh> meshes, std::vector<Instance> instances) {
  return *InstancedMeshes::make(std::move(meshes), std::move(instances));
}

bool same(const ExactHit& a, const ExactHit& b) { return a.t == b.t && a.prims == b.prims; }

// Maps that floats carry out exactly make the same scene as the triangles that they make.
TEST(ExactInstances, AreTheirTrianglesWhereMapsAreExact) {
  const TriangleMesh soup = mesh_of(random_triangles(100, 0.4f, 11));
  const Affine exact{{{0, 0, -4, 0}, {0.5f, 0, 0, 0}, {0, 8, 0, 0}}};
  const InstancedMeshes scene = made({soup}, {{0, {}}, {0, exact}});
  const ExactOracle placed(scene), flat(*scene.flattened());
  for (const Ray& ray : instance_rays(scene, 2000, 11)) EXPECT_TRUE(same(placed.closest(ray), flat.closest(ray)));
}

TEST(ExactInstances, TheTreeLosesNothing) {
  for (const InstancedScene& s : instanced_scenes(12)) {
    const ExactOracle tree(s.scene), all(s.scene, ExactOracle::Search::all);
    for (const Ray& ray : instance_rays(s.scene, 60, 12)) {
      EXPECT_TRUE(same(tree.closest(ray), all.closest(ray))) << s.name;
      EXPECT_EQ(tree.any(ray), all.any(ray)) << s.name;
    }
  }
}

// A vertex at 3 * fl(1/3), which no float is: rays one float to either side of it.
TEST(ExactInstances, TellWhatRoundedVerticesCannot) {
  const float third = 1.0f / 3, vertex = 3;
  const double product = double{third} * vertex;
  ASSERT_NE(product, static_cast<float>(product));
  Affine shrink;
  shrink.m[0][0] = third;
  const ExactOracle oracle(made({mesh_of({{{vertex, 0, 0}, {9, 0, 0}, {vertex, 9, 0}}})}, {{0, shrink}}));
  const auto at = [&](float x) { return oracle.closest({{x, 1, 1}, 0, {0, 0, -1}}).prims; };
  const float above = round_up(product), below = round_down(product);
  ASSERT_EQ(next_up(below), above);
  EXPECT_THAT(at(above), ElementsAre(0));
  EXPECT_THAT(at(below), IsEmpty());
}

// What the traversers' arithmetic answers is never refuted, and the bound has some use: t moved by a hundred of its error is.
TEST(JudgeOfInstances, ExcusesRoundingAndNothingElse) {
  for (const InstancedScene& s : instanced_scenes(13)) {
    const Judge judge(s.scene);
    std::size_t hits = 0, refuted = 0;
    for (const Ray& ray : instance_rays(s.scene, 600, 13)) {
      Hit hit = brute_force<Watertight>(s.scene, ray);
      const ExactHit exact = judge.oracle().closest(ray);
      const Verdict verdict = judge.judge(ray, hit, exact);
      EXPECT_FALSE(is_failure(verdict)) << s.name << ": " << to_string(verdict);
      EXPECT_FALSE(is_failure(judge.judge_any(ray, hit.valid(), exact.valid()))) << s.name;
      if (verdict != Verdict::right || !hit.valid() || !(hit.t > 0)) continue;
      ++hits;
      hit.t *= 1.01f;
      refuted += is_failure(judge.judge(ray, hit, exact));
    }
    EXPECT_GE(refuted, hits - hits / 10) << s.name << ": a hundredth of t is excused";
  }
}

// Hits of triangles that the ray passes by are false, misses of what it must meet are misses.
TEST(JudgeOfInstances, RefutesWrongAnswers) {
  const InstancedMeshes scene =
      made({mesh_of({{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}})}, {{0, placed_at({0, 0, -2}, {1, 1, 1}, 1, 1)}, {0, {}}});
  const Judge judge(scene);
  const Ray ray{{0, 0, 3}, 0, {0, 0, -1}};
  const ExactHit exact = judge.oracle().closest(ray);
  ASSERT_THAT(exact.prims, ElementsAre(1));
  EXPECT_EQ(judge.judge(ray, {3, 0.25f, 0.5f, 1}, exact), Verdict::right);
  EXPECT_EQ(judge.judge(ray, Hit{}, exact), Verdict::miss);
  EXPECT_EQ(judge.judge(ray, {3, 0.25f, 0.5f, 0}, exact), Verdict::false_hit);
  EXPECT_EQ(judge.judge(ray, {3, 0.25f, 0.5f, 2}, exact), Verdict::false_hit);
  EXPECT_EQ(judge.judge(ray, {3.01f, 0.25f, 0.5f, 1}, exact), Verdict::far);
  EXPECT_EQ(judge.judge_any(ray, false, true), Verdict::miss);
}

// A map that all but flattens space: its inverse is in range, and rounding may turn a ray in its space by more than it has of
// direction. What the traversers' arithmetic finds there is excused, and proves nothing.
TEST(JudgeOfInstances, ExcusesEverythingWhereRoundingMayTurnTheRay) {
  const Affine flat{{{1, 0, 0, 0}, {0, 1, 1, 0}, {0, 1, 1 + 0x1p-23f, 0}}};
  const InstancedMeshes scene = made({mesh_of({{{-1, 0, -1}, {2, 0, -1}, {0, 0, 2}}})}, {{0, flat}});
  const Judge judge(scene);
  const Ray ray{{0.25f, -2, -2}, 0, {0, 1, 1}};
  const Hit hit = brute_force<Watertight>(scene, ray);
  ASSERT_TRUE(hit.valid());
  const ExactHit exact = judge.oracle().closest(ray);
  EXPECT_FALSE(is_failure(judge.judge(ray, hit, exact)));
  EXPECT_FALSE(is_failure(judge.judge(ray, Hit{}, exact)));
  EXPECT_FALSE(is_failure(judge.judge_any(ray, true, exact.valid())));
  EXPECT_FALSE(is_failure(judge.judge_any(ray, false, exact.valid())));
}

// Edges inside of an instance leak nothing; two instances side by side share none.
TEST(JudgeOfInstances, MustHitHoldsInsideOfAnInstance) {
  const TriangleMesh square = mesh_of({{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, {{0, 0, 0}, {1, 1, 0}, {0, 1, 0}}});
  const Affine turned = placed_at({0.1f, 0.2f, 0.3f}, {1, 1, 1}, 3, 4);
  const Vec3d middle = transform_point(turned, {0.5, 0.5, 0}), above = transform_point(turned, {0.5, 0.5, 1});
  const Ray ray{above.to_float(), 0, (middle - above).to_float()};
  const Judge one(made({square}, {{0, turned}}));
  EXPECT_EQ(one.judge(ray, Hit{}, one.oracle().closest(ray)), one.oracle().any(ray) ? Verdict::miss : Verdict::right);
  EXPECT_TRUE(one.oracle().any(ray)) << "the square has no gap";

  const auto half = [](std::uint32_t i, const TriangleMesh& mesh) { return mesh_of({mesh.triangle(i)}); };
  const Judge two(made({half(0, square), half(1, square)}, {{0, turned}, {1, turned}}));
  EXPECT_EQ(two.judge(ray, Hit{}, two.oracle().closest(ray)), Verdict::edge);
}

}  // namespace
}  // namespace accel::validation
