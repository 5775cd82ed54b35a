#include "libaccel/rays/offset_origin.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libaccel/core/counter_rng.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/rays/sampling.h"
#include "validation/oracle/brute_instances.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

Vec3 random_point(CounterRng& rng, float reach) {
  const float x = rng.next_float(-reach, reach), y = rng.next_float(-reach, reach), z = rng.next_float(-reach, reach);
  return {x, y, z};
}

// A triangle somewhere between the origin and 1000 of its own sizes away, of any size between 2^-40 and 2^40; not a sliver.
Triangle random_triangle(CounterRng& rng) {
  const float size = std::ldexp(1.0f, static_cast<int>(rng.next_below(81)) - 40);
  const Vec3 center = random_point(rng, size * (rng.next_below(2) == 0 ? 1.0f : 1000.0f));
  while (true) {
    const Triangle t{center + random_point(rng, size), center + random_point(rng, size), center + random_point(rng, size)};
    const Vec3d a = Vec3d(t.v1) - Vec3d(t.v0), b = Vec3d(t.v2) - Vec3d(t.v0);
    const double longest = std::fmax(length(a), std::fmax(length(b), length(a - b)));
    if (length(cross(a, b)) > 0.1 * longest * longest) return t;
  }
}

Hit random_hit(CounterRng& rng) {
  float u = rng.next_float(), v = rng.next_float();
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return {1.0f, u, v, 0};
}

TEST(OffsetOrigin, LeavingRaysMissTheTriangleThatTheyLeave) {
  for (std::uint32_t i = 0; i < 200000; ++i) {
    CounterRng rng(1, i);
    const Triangle triangle = random_triangle(rng);
    const SurfacePoint point = offset_origin(triangle, random_hit(rng), sphere_direction(rng).to_float());
    const Ray ray{.org = point.org, .dir = cosine_direction(point.normal, rng).to_float()};
    Hit hit;
    const bool line_met = Watertight::intersect(pack(triangle, 0), ray, Watertight::prepare(ray), hit);
    ASSERT_FALSE(line_met && hit.t >= 0) << "case " << i << ", t = " << hit.t;
  }
}

// The triangle is where a map takes it, and the leaving ray is tested where it comes from.
TEST(OffsetOrigin, LeavingRaysMissTheInstanceThatTheyLeave) {
  for (std::uint32_t i = 0; i < 20000; ++i) {
    CounterRng rng(3, i);
    const Triangle triangle = random_triangle(rng);
    const float size = std::sqrt(Aabb(triangle.bounds()).half_area());
    const Vec3 scale{rng.next_float(0.5f, 2), -rng.next_float(0.5f, 2), rng.next_float(0.5f, 2)};
    const Affine map = placed_by(scale, random_point(rng, 1), rng.next_float(0, 360), random_point(rng, 300 * size));
    const auto scene = InstancedMeshes::make({validation::mesh_of({triangle})}, {{0, map}});
    ASSERT_TRUE(scene) << scene.message();
    const SurfacePoint point =
        offset_origin(scene->triangle(0), random_hit(rng), sphere_direction(rng).to_float(), scene->position_error(0));
    const Ray ray{.org = point.org, .dir = cosine_direction(point.normal, rng).to_float()};
    EXPECT_FALSE(validation::brute_force<Watertight>(*scene, ray).valid()) << "case " << i;
  }
}

TEST(OffsetOrigin, StaysCloseToTheSurface) {
  for (std::uint32_t i = 0; i < 10000; ++i) {
    CounterRng rng(2, i);
    const Triangle triangle = random_triangle(rng);
    const Hit hit = random_hit(rng);
    const SurfacePoint point = offset_origin(triangle, hit, sphere_direction(rng).to_float());
    const Vec3d v0(triangle.v0), v1(triangle.v1), v2(triangle.v2);
    const Vec3d p = v0 * (1.0 - hit.u - hit.v) + v1 * hit.u + v2 * hit.v;
    const double extent = length(v1 - v0) + length(v2 - v0), farthest = length(v0) + extent;
    EXPECT_LE(length(Vec3d(point.org) - p), 64 * 0x1p-24 * extent + 2 * 0x1p-24 * farthest);
    EXPECT_GT(dot(Vec3d(point.org) - v0, point.normal), 0);
  }
}

TEST(OffsetOrigin, NormalFacesTheViewer) {
  const Triangle triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(offset_origin(triangle, {1, 0.25f, 0.25f, 0}, {0, 0, -1}).normal.z, 1);
  EXPECT_EQ(offset_origin(triangle, {1, 0.25f, 0.25f, 0}, {0, 0, 1}).normal.z, -1);
  EXPECT_LT(offset_origin(triangle, {1, 0.25f, 0.25f, 0}, {0, 0, 1}).org.z, 0);
}

TEST(OffsetOrigin, TrianglesWithoutAreaSendRaysBack) {
  const Triangle point{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  EXPECT_EQ(offset_origin(point, {1, 0, 0, 0}, {0, 2, 0}).normal.y, -1);
}

}  // namespace
}  // namespace accel
