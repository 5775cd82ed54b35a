#include "libaccel/geometry/located_bounds.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libaccel/geometry/watertight.h"
#include "libaccel/rays/offset_origin.h"
#include "validation/stress/hostile_floats.h"

namespace accel {
namespace {

using validation::random_in_cube;
using validation::random_over_exponents;

// The bounds for a ray that meets the triangle, and t itself.
struct Located {
  bool meets = false;
  float t = 0;
  LocatedBounds::Interval bounds{};
};

Located locate(const Triangle& triangle, const Ray& ray) {
  const PackedTriangle packed = pack(triangle, 0);
  const auto data = Watertight::prepare(ray);
  Aabb scene;
  for (int i = 0; i < 3; ++i) scene.extend(packed.vertex(i));
  const float origin = max_of(max_of(std::fabs(ray.org.x), std::fabs(ray.org.y)), std::fabs(ray.org.z));
  const float reach = LocatedBounds::reach(scene, origin, std::fabs(data.dir_z), std::fabs(data.dir_z));
  Hit hit;
  if (std::isinf(reach) || !Watertight::intersect(packed, ray, data, hit)) return {};

  double e1[3], e2[3];
  for (int a = 0; a < 3; ++a) {
    const double v0 = packed.axis[a].vertex[0];
    e1[a] = packed.axis[a].vertex[1] - v0, e2[a] = packed.axis[a].vertex[2] - v0;
  }
  const double normal[3] = {e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2], e1[0] * e2[1] - e1[1] * e2[0]};
  const double edges =
      (std::fabs(e1[0]) + std::fabs(e1[1]) + std::fabs(e1[2])) * (std::fabs(e2[0]) + std::fabs(e2[1]) + std::fabs(e2[2]));
  return {true, hit.t, LocatedBounds(normal, edges, reach).of(packed, ray, data.kz)};
}

// Slivers, needles and flat ones among them, in a scene of some size around some place.
Triangle random_triangle(CounterRng& rng, Vec3 place, float size) {
  Triangle t{random_in_cube(rng, size), random_in_cube(rng, size), random_in_cube(rng, size)};
  const std::uint32_t kind = rng.next_below(5);
  const float thin = std::fabs(random_over_exponents(rng, -40, -1));
  if (kind == 0) t.v2 = t.v0 * 0.25f + t.v1 * 0.75f + random_in_cube(rng, size * thin);
  if (kind == 1) t.v2 = t.v1 + random_in_cube(rng, size * thin);
  if (kind == 2) t.v1.y = t.v2.y = t.v0.y;
  if (kind == 3) t.v1 = t.v0 + t.v1 * thin, t.v2 = t.v0 + t.v2 * thin;
  return {place + t.v0, place + t.v1, place + t.v2};
}

// At a point of the triangle or by a hair beyond an edge, from far away, from near by, or along the plane.
Ray random_ray(CounterRng& rng, const Triangle& t, float size) {
  const float u = rng.next_float(-0.01f, 1.01f), v = rng.next_float(-0.01f, 1.01f);
  const Vec3 e1 = t.v1 - t.v0, e2 = t.v2 - t.v0,
             target = t.v0 + (u + v < 1.02f ? e1 * u + e2 * v : e1 * (1 - u) + e2 * (1 - v));
  const float distance = std::fabs(random_over_exponents(rng, -26, 2));
  Vec3 dir = random_in_cube(rng, 1);
  if (rng.next_below(3) == 0) {
    const Vec3 along = e1 * rng.next_float(-1, 1) + e2 * rng.next_float(-1, 1);
    dir = along * (1 / size) + dir * std::fabs(random_over_exponents(rng, -26, -2));
  }
  return {.org = target - dir * (size * distance), .dir = dir * random_over_exponents(rng, -29, 28)};
}

TEST(LocatedBounds, HoldT) {
  std::size_t met = 0, narrow = 0;
  for (std::uint64_t i = 0; i < 1'000'000; ++i) {
    CounterRng rng(1, i);
    const float size = std::fabs(random_over_exponents(rng, -30, 30));
    const Vec3 place =
        rng.next_below(2) == 0 ? Vec3{} : random_in_cube(rng, size * std::fabs(random_over_exponents(rng, 0, 9)));
    const Triangle triangle = random_triangle(rng, place, size);
    const Ray ray = random_ray(rng, triangle, size);
    const Located at = locate(triangle, ray);
    if (!at.meets) continue;
    ++met;
    narrow += at.bounds.most - at.bounds.least <= 0x1p-12f * std::fabs(at.t) ? 1 : 0;
    ASSERT_FALSE(at.t < at.bounds.least || at.t > at.bounds.most)
        << i << ": t " << at.t << " in [" << at.bounds.least << ", " << at.bounds.most << "]";
  }
  EXPECT_GT(met, 300'000u);
  EXPECT_GT(narrow, met / 4);  // bounds that always hold might be no bounds
}

// What half of the triangles that shadow rays meet are asked.
TEST(LocatedBounds, TellThatARayHasLeftItsSurface) {
  std::size_t met = 0, told = 0;
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    CounterRng rng(2, i);
    const Triangle triangle{random_in_cube(rng, 1), random_in_cube(rng, 1), random_in_cube(rng, 1)};
    const float u = rng.next_float(0, 0.5f), v = rng.next_float(0, 0.5f);
    const Vec3 target = triangle.v0 + (triangle.v1 - triangle.v0) * u + (triangle.v2 - triangle.v0) * v;
    const Ray viewer{.org = random_in_cube(rng, 3), .dir = {}};
    const Vec3 dir = target - viewer.org;
    const SurfacePoint from = offset_origin(triangle, Hit{1, u, v, 0}, dir);
    Ray ray{.org = from.org, .dir = random_in_cube(rng, 1)};
    if (dot(Vec3d(ray.dir), from.normal) < 0) ray.dir = ray.dir * -1.0f;
    const Located at = locate(triangle, ray);
    if (!at.meets) continue;
    ++met, told += at.bounds.most < 0 ? 1 : 0;
  }
  EXPECT_GT(met, 100'000u);
  EXPECT_GT(told, met * 9 / 10);
}

TEST(LocatedBounds, ThereAreNoneForSizesThatOverflowOrUnderflow) {
  const Aabb scene{{-1, -1, -1}, {1, 2, 1}};
  EXPECT_EQ(LocatedBounds::reach(scene, 1, 1, 1), 4);
  EXPECT_EQ(LocatedBounds::reach(scene, 8, 1, 1), 16);
  EXPECT_EQ(LocatedBounds::reach(scene, 0x1p41f, 1, 1), std::numeric_limits<float>::infinity());
  EXPECT_EQ(LocatedBounds::reach({{0, 0, 0}, {0x1p-41f, 0, 0}}, 0, 1, 1), std::numeric_limits<float>::infinity());
  EXPECT_EQ(LocatedBounds::reach(scene, 1, 0x1p-31f, 1), std::numeric_limits<float>::infinity());
  EXPECT_EQ(LocatedBounds::reach(scene, 1, 1, 0x1p31f), std::numeric_limits<float>::infinity());
}

}  // namespace
}  // namespace accel
