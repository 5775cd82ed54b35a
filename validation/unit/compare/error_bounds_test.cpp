#include "validation/compare/error_bounds.h"

#include <gtest/gtest.h>

#include "validation/oracle/exact_predicates.h"
#include "validation/unit/compare/test_scenes.h"

namespace accel::validation {
namespace {

// A triangle near the ray: some vertices or edges almost on it, some triangles edge-on, small, far, or at any scale.
struct Case {
  Ray ray;
  Triangle triangle;
};

Case random_case(test::Random& random) {
  const float scale = std::exp2(std::round(test::uniform(random, -30, 30)));
  const float size = std::exp2(test::uniform(random, -10, 0));
  const Vec3 org = test::uniform_point(random, 1), dir = test::uniform_point(random, 1);
  const auto on_ray = [&] { return org + dir * test::uniform(random, 0.1f, 2); };
  const Vec3 centre = on_ray();
  const auto vertex = [&] { return random() % 4 == 0 ? on_ray() : centre + test::uniform_point(random, size); };
  const Vec3 v0 = vertex(), v1 = vertex();
  // A third vertex that puts the ray on the edge between two, in one case out of three.
  const Vec3 v2 = random() % 3 == 0 ? centre + (centre - v0) * test::uniform(random, 0.1f, 2) : vertex();
  return {{org * scale, 0, dir * scale}, {v0 * scale, v1 * scale, v2 * scale}};
}

template <class Check>
void for_random_cases(std::size_t count, const Check& check) {
  test::Random random(5);
  for (std::size_t i = 0; i < count; ++i) {
    const Case c = random_case(random);
    const Watertight::RayData data = Watertight::prepare(c.ray);
    Hit hit;
    const bool accepted = Watertight::intersect_scalar(pack(c.triangle, 0), c.ray, data, hit);
    check(c, TriangleBounds(RayFrame(c.ray), c.triangle), accepted, hit);
  }
}

TEST(ErrorBounds, WhatIsAcceptedWasPossible) {
  std::size_t accepted_count = 0;
  for_random_cases(300'000, [&](const Case&, const TriangleBounds& bounds, bool accepted, const Hit& hit) {
    if (!accepted) return;
    ++accepted_count;
    EXPECT_TRUE(bounds.possible);
    EXPECT_TRUE(bounds.allows(hit.t)) << hit.t << " not in [" << bounds.t_lo << ", " << bounds.t_hi << "]";
  });
  EXPECT_GT(accepted_count, 50'000);
}

TEST(ErrorBounds, WhatIsNearNoEdgeIsAccepted) {
  std::size_t sure = 0;
  for_random_cases(300'000, [&](const Case&, const TriangleBounds& bounds, bool accepted, const Hit&) {
    if (!bounds.possible || bounds.near_any_edge()) return;
    ++sure;
    EXPECT_TRUE(accepted);
  });
  EXPECT_GT(sure, 20'000);
}

TEST(ErrorBounds, TheExactAnswerIsPossible) {
  for_random_cases(50'000, [&](const Case& c, const TriangleBounds& bounds, bool, const Hit&) {
    const ExactCrossing exact = exact_crossing(c.ray, c.triangle);
    if (!exact.meets()) return;
    EXPECT_TRUE(bounds.allows(to_double(exact.t())));
  });
}

// t from single-precision edge functions, as Woop, Benthin and Wald print it and other engines compute it.
float interpolated_t(const Case& c) {
  const Watertight::RayData ray = Watertight::prepare(c.ray);
  const PackedTriangle packed = pack(c.triangle, 0);
  float x[3], y[3], z[3];
  for (int i = 0; i < 3; ++i) {
    z[i] = packed.axis[ray.kz].vertex[i] - ray.org_z;
    x[i] = (packed.axis[ray.kx].vertex[i] - ray.org_x) - ray.shear_x * z[i];
    y[i] = (packed.axis[ray.ky].vertex[i] - ray.org_y) - ray.shear_y * z[i];
  }
  const float u = x[2] * y[1] - y[2] * x[1], v = x[0] * y[2] - y[0] * x[2], w = x[1] * y[0] - y[1] * x[0];
  const float det = u + v + w;
  return (u / det * z[0] + v / det * z[1] + w / det * z[2]) / ray.dir_z;
}

// A bound is worth something only if it is not much larger than the errors: of the triangles that rounding puts on the wrong
// side of an edge, and of the distances of a test that interpolates them from its rounded edge functions.
TEST(ErrorBounds, AreNotLoose) {
  std::size_t undecided = 0, wrong = 0;
  double largest_share = 0;
  for_random_cases(60'000, [&](const Case& c, const TriangleBounds& bounds, bool accepted, const Hit& hit) {
    const FilteredCrossing filtered = filter_crossing(c.ray, c.triangle);
    const ExactCrossing exact = exact_crossing(c.ray, c.triangle);
    undecided += bounds.possible && bounds.near_any_edge();
    wrong += accepted != exact.meets();
    if (!accepted || filtered.meets != Decision::yes) return;
    const double t = to_double(exact.t()), radius = std::max(bounds.t_hi - t, t - bounds.t_lo);
    EXPECT_LE(std::abs(hit.t - t), radius);
    largest_share = std::max(largest_share, std::abs(interpolated_t(c) - t) / radius);
  });
  EXPECT_GT(wrong, undecided / 20);
  EXPECT_GT(largest_share, 0.2);
  EXPECT_LE(largest_share, 1);
}

TEST(ErrorBounds, ScaleByPowersOfTwo) {
  for_random_cases(1000, [&](const Case& c, const TriangleBounds& bounds, bool, const Hit&) {
    const float s = 0x1p12f;
    const Ray ray{c.ray.org * s, 0, c.ray.dir * s};
    const TriangleBounds scaled(RayFrame(ray), Triangle{c.triangle.v0 * s, c.triangle.v1 * s, c.triangle.v2 * s});
    EXPECT_EQ(scaled.possible, bounds.possible);
    EXPECT_EQ(scaled.edge_near, bounds.edge_near);
  });
}

}  // namespace
}  // namespace accel::validation
