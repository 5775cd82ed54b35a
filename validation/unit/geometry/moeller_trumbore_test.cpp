#include "libaccel/geometry/moeller_trumbore.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/traverser.h"
#include "validation/stress/hostile_floats.h"

namespace accel {
namespace {

template <class Test>
bool hits(const PackedTriangle& triangle, const Ray& ray, Hit& hit) {
  Hit candidate;
  begin_hit(ray, hit);
  if (!is_traceable(ray) || !Test::intersect(triangle, ray, Test::prepare(ray), candidate)) return false;
  candidate.prim_id = triangle.prim_id();
  return accept_hit(candidate, first_t(ray), hit);
}

TEST(MoellerTrumbore, FindsDistanceAndBarycentrics) {
  const PackedTriangle triangle = pack({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, 7);
  Hit hit;
  ASSERT_TRUE(hits<MoellerTrumbore>(triangle, {.org = {0.25f, 0.5f, 2}, .dir = {0, 0, -0.5f}}, hit));
  EXPECT_EQ(hit.t, 4.0f);
  EXPECT_EQ(hit.u, 0.25f);
  EXPECT_EQ(hit.v, 0.5f);
  ASSERT_TRUE(hits<MoellerTrumbore>(triangle, {.org = {0.25f, 0.5f, -2}, .dir = {0, 0, 1}}, hit));
  EXPECT_EQ(hit.t, 2.0f);
  EXPECT_FALSE(hits<MoellerTrumbore>(triangle, {.org = {0.75f, 0.5f, 2}, .dir = {0, 0, -1}}, hit));
}

TEST(MoellerTrumbore, NaNAndInfinityMiss) {
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity()})
    for (int coordinate = 0; coordinate < 9; ++coordinate) {
      Triangle triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
      (&triangle.v0)[coordinate / 3][coordinate % 3] = bad;
      Hit hit;
      EXPECT_FALSE(hits<MoellerTrumbore>(pack(triangle, 0), {.org = {0.2f, 0.2f, 1}, .dir = {0.05f, 0.05f, -1}}, hit))
          << coordinate;
    }
}

TEST(MoellerTrumbore, ParallelAndDegenerateMiss) {
  Hit hit;
  EXPECT_FALSE(
      hits<MoellerTrumbore>(pack({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, 0), {.org = {-1, 0.2f, 0}, .dir = {1, 0, 0}}, hit));
  EXPECT_FALSE(
      hits<MoellerTrumbore>(pack({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, 0), {.org = {0.5f, 0, 1}, .dir = {0, 0, -1}}, hit));
}

// Away from edges, and seen at no flat angle, both tests see the same triangle at the same place.
TEST(MoellerTrumbore, AgreesWithWatertightInsideTriangles) {
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    CounterRng rng(1, i);
    const Triangle t{validation::random_in_cube(rng, 1), validation::random_in_cube(rng, 1),
                     validation::random_in_cube(rng, 1)};
    const Vec3 normal = cross(t.v1 - t.v0, t.v2 - t.v0), org = validation::random_in_cube(rng, 3);
    const Vec3 dir = t.v0 * 0.3f + t.v1 * 0.3f + t.v2 * 0.4f - org;
    if (!(std::fabs(dot(normal, dir)) > 0.1f)) continue;
    Hit ours, reference;
    ASSERT_TRUE(hits<MoellerTrumbore>(pack(t, 0), {.org = org, .dir = dir}, ours)) << i;
    ASSERT_TRUE(hits<Watertight>(pack(t, 0), {.org = org, .dir = dir}, reference)) << i;
    EXPECT_NEAR(ours.t, reference.t, 1e-4f);
    EXPECT_NEAR(ours.u, reference.u, 1e-4f);
    EXPECT_NEAR(ours.v, reference.v, 1e-4f);
  }
}

}  // namespace
}  // namespace accel
