#include "libaccel/geometry/watertight.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <vector>

#include "libaccel/core/float_bounds.h"
#include "libaccel/trace/traverser.h"
#include "validation/oracle/exact_predicates.h"
#include "validation/stress/hostile_floats.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

const PackedTriangle kTriangle = pack({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, 7);

bool same_bits(float a, float b) {
  return (std::isnan(a) && std::isnan(b)) || std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

// Whether the triangle is hit by the rules that traversers share.
bool hits(const PackedTriangle& triangle, const Ray& ray, Hit& hit) {
  Hit candidate;
  begin_hit(ray, hit);
  if (!is_traceable(ray) || !Watertight::intersect(triangle, ray, Watertight::prepare(ray), candidate)) return false;
  candidate.prim_id = triangle.prim_id();
  return accept_hit(candidate, first_t(ray), hit);
}
bool hits(const PackedTriangle& triangle, const Ray& ray) {
  Hit hit;
  return hits(triangle, ray, hit);
}

TEST(Watertight, FindsDistanceAndBarycentrics) {
  Hit hit;
  ASSERT_TRUE(hits(kTriangle, {.org = {0.25f, 0.5f, 2}, .dir = {0, 0, -0.5f}}, hit));
  EXPECT_EQ(hit.t, 4.0f);
  EXPECT_EQ(hit.u, 0.25f);
  EXPECT_EQ(hit.v, 0.5f);
  EXPECT_EQ(hit.prim_id, 7u);

  // From behind as well: nothing is culled.
  ASSERT_TRUE(hits(kTriangle, {.org = {0.25f, 0.5f, -2}, .dir = {0, 0, 1}}, hit));
  EXPECT_EQ(hit.t, 2.0f);
  EXPECT_EQ(hit.u, 0.25f);
}

TEST(Watertight, MissesBesideAndBehind) {
  EXPECT_FALSE(hits(kTriangle, {.org = {-0.1f, 0.5f, 1}, .dir = {0, 0, -1}}));
  EXPECT_FALSE(hits(kTriangle, {.org = {0.6f, 0.6f, 1}, .dir = {0, 0, -1}}));
  EXPECT_FALSE(hits(kTriangle, {.org = {0.25f, 0.25f, 1}, .dir = {0, 0, 1}}));
}

TEST(Watertight, EdgesAndVerticesBelongToTheTriangle) {
  for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0.5f, 0, 0}, Vec3{0, 0.5f, 0}, Vec3{0.5f, 0.5f, 0}}) {
    EXPECT_TRUE(hits(kTriangle, {.org = {p.x, p.y, 1}, .dir = {0, 0, -1}}));
    EXPECT_TRUE(hits(kTriangle, {.org = {p.x, p.y, 0}, .dir = {0, 0, -1}})) << "origin on the surface";
  }
}

TEST(Watertight, IntervalIsClosed) {
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    CounterRng rng(1, i);
    const PackedTriangle triangle =
        pack({validation::random_in_cube(rng, 1), validation::random_in_cube(rng, 1), validation::random_in_cube(rng, 1)}, 0);
    Ray ray{.org = validation::random_in_cube(rng, 2), .dir = {}};
    ray.dir = (triangle.vertex(0) + triangle.vertex(1) + triangle.vertex(2)) * (1.0f / 3.0f) - ray.org;
    Hit hit;
    if (!hits(triangle, ray, hit)) continue;
    const float t = hit.t;
    ray.t_max = t;
    EXPECT_TRUE(hits(triangle, ray));
    ray.t_max = next_down(t);
    EXPECT_FALSE(hits(triangle, ray));
    ray.t_max = kInfinity, ray.t_min = t;
    EXPECT_TRUE(hits(triangle, ray));
    ray.t_min = next_up(t);
    EXPECT_FALSE(hits(triangle, ray));
  }
}

TEST(Watertight, SimdHasTheBitsOfTheScalarVersion) {
  int hit_count = 0;
  for (std::uint64_t i = 0; i < 300'000; ++i) {
    CounterRng rng(2, i);
    const bool hostile = i % 3 == 0;
    const auto point = [&] { return hostile ? validation::hostile_vec3(rng, 12) : validation::random_in_cube(rng, 1); };
    const Triangle triangle{point(), point(), i % 11 == 0 ? Vec3{0, 0, 0} : point()};
    Ray ray{.org = point(), .dir = point()};
    if (i % 3 == 1) ray.dir = triangle.v0 * 0.5f + triangle.v1 * 0.5f - ray.org;  // at an edge
    const PackedTriangle packed = pack(triangle, static_cast<std::uint32_t>(rng.next_u64()));
    const Watertight::RayData data = Watertight::prepare(ray);
    Hit scalar, simd;
    const bool scalar_hit = Watertight::intersect_scalar(packed, ray, data, scalar);
    ASSERT_EQ(Watertight::intersect(packed, ray, data, simd), scalar_hit) << i;
    if (!scalar_hit) continue;
    ++hit_count;
    ASSERT_TRUE(same_bits(scalar.t, simd.t) && same_bits(scalar.u, simd.u) && same_bits(scalar.v, simd.v)) << i;
  }
  EXPECT_GT(hit_count, 10'000);
}

TEST(Watertight, NaNAndInfinityMiss) {
  for (const float bad : {std::nanf(""), kInfinity, -kInfinity})
    for (int coordinate = 0; coordinate < 9; ++coordinate)
      for (const Vec3 dir : {Vec3{0, 0, -1}, Vec3{0.1f, 0.2f, -1}, Vec3{1, 0.2f, -0.1f}}) {
        Triangle triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        (&triangle.v0)[coordinate / 3][coordinate % 3] = bad;
        EXPECT_FALSE(hits(pack(triangle, 0), {.org = Vec3{0.25f, 0.25f, 0} - dir, .dir = dir})) << bad << ' ' << coordinate;
      }
}

TEST(Watertight, DegenerateTrianglesMissOrLieOnTheirLine) {
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    CounterRng rng(3, i);
    const Vec3 a = validation::random_in_cube(rng, 1), b = i % 2 == 0 ? a : validation::random_in_cube(rng, 1);
    Hit hit;
    if (!hits(pack({a, b, b}, 0), {.org = {3, 2, 1}, .dir = a * 0.5f + b * 0.5f - Vec3{3, 2, 1}}, hit)) continue;
    EXPECT_TRUE(std::isfinite(hit.t));
    EXPECT_NEAR(hit.t, 1.0f, 1e-3f);
  }
}

// The float next to the exact distance, also where the triangle is a thousand times larger than its distance, which defeats
// distances that are interpolated from rounded vertices.
TEST(Watertight, DistancesAreCorrectlyRounded) {
  int hit_count = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    CounterRng rng(9, i);
    const float size = std::ldexp(1.0f, static_cast<int>(i % 11));
    const Triangle triangle{validation::random_in_cube(rng, size), validation::random_in_cube(rng, size),
                            validation::random_in_cube(rng, size)};
    const Vec3 target = triangle.v0 * 0.3f + triangle.v1 * 0.3f + triangle.v2 * 0.4f;
    const Vec3 dir = validation::random_in_cube(rng, 1);
    const Ray ray{.org = target - dir, .dir = dir};
    const Vec3 normal = cross(triangle.v1 - triangle.v0, triangle.v2 - triangle.v0);
    const float cosine = dot(normal, dir) / std::sqrt(dot(normal, normal) * dot(dir, dir));
    Hit hit;
    if (!(std::fabs(cosine) > 0.01f) || !Watertight::intersect(pack(triangle, 0), ray, Watertight::prepare(ray), hit)) continue;
    ++hit_count;
    const double exact = validation::to_double(validation::exact_crossing(ray, triangle).t());
    EXPECT_LE(std::fabs(hit.t - exact), 0.5001 * (next_up(hit.t) - hit.t)) << i << ": " << hit.t << ", exact " << exact;
  }
  EXPECT_GT(hit_count, 10'000);
}

// Triangles that are tiny beside their distance from the ray: all products of their coordinates round to nearly the same
// number, and only their exact difference tells on which side the ray passes.
TEST(Watertight, TinyTrianglesFarFromTheRayAreMissed) {
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    CounterRng rng(8, i);
    const float size = std::ldexp(1.0f, -16 - static_cast<int>(i % 12));
    const Vec3 at = validation::random_in_cube(rng, 1);
    const Triangle triangle{at + validation::random_in_cube(rng, size), at + validation::random_in_cube(rng, size),
                            at + validation::random_in_cube(rng, size)};
    const Ray ray{.org = validation::random_in_cube(rng, 4), .dir = validation::random_in_cube(rng, 1)};
    const Vec3 to_ray = cross(at - ray.org, ray.dir);
    if (dot(to_ray, to_ray) < 0.01f * dot(ray.dir, ray.dir)) continue;  // passes within a tenth
    EXPECT_FALSE(hits(pack(triangle, 0), ray)) << i;
  }
}

Vec3 scaled(Vec3 v, int k) { return {std::ldexp(v.x, k), std::ldexp(v.y, k), std::ldexp(v.z, k)}; }

// Scaling scene and origin by 2^k scales t; scaling the direction as well leaves it alone. No bit may change otherwise.
TEST(Watertight, PowersOfTwoScaleExactly) {
  int hit_count = 0;
  for (std::uint64_t i = 0; i < 5'000; ++i) {
    CounterRng rng(4, i);
    const Triangle t{validation::random_in_cube(rng, 1), validation::random_in_cube(rng, 1),
                     validation::random_in_cube(rng, 1)};
    const Vec3 org = validation::random_in_cube(rng, 4);
    const Vec3 dir = t.v0 * 0.25f + t.v1 * 0.25f + t.v2 * 0.5f - org;
    Hit reference;
    const bool expected = hits(pack(t, 0), {.org = org, .dir = dir}, reference);
    hit_count += expected;
    for (int k = -40; k <= 40; ++k) {
      const PackedTriangle triangle = pack({scaled(t.v0, k), scaled(t.v1, k), scaled(t.v2, k)}, 0);
      Hit both, scene_only;
      ASSERT_EQ(hits(triangle, {.org = scaled(org, k), .dir = scaled(dir, k)}, both), expected);
      ASSERT_EQ(hits(triangle, {.org = scaled(org, k), .dir = dir}, scene_only), expected);
      if (!expected) continue;
      ASSERT_TRUE(both.t == reference.t && both.u == reference.u && both.v == reference.v) << k;
      ASSERT_TRUE(scene_only.t == std::ldexp(reference.t, k) && scene_only.u == reference.u && scene_only.v == reference.v)
          << k;
    }
  }
  EXPECT_GT(hit_count, 4'000);
}

// The points of a shared edge, and its vertices, as floats.
Vec3 edge_point(Vec3 a, Vec3 b, float s) { return a * (1.0f - s) + b * s; }

bool hits_any(const std::vector<PackedTriangle>& triangles, const Ray& ray) {
  for (const PackedTriangle& triangle : triangles)
    if (hits(triangle, ray)) return true;
  return false;
}

// A fan around a centre, closed: rays that pass near its spokes and its centre, well inside of its rim, cannot miss it.
TEST(Watertight, FansDoNotLeakAtTheirSpokes) {
  std::uint64_t rays = 0;
  for (std::uint64_t i = 0; i < 400; ++i) {
    CounterRng rng(5, i);
    const int spokes = 3 + static_cast<int>(rng.next_below(10));
    const Vec3 offset = validation::random_in_cube(rng, i % 2 == 0 ? 0.0f : 1000.0f);
    const Vec3 center = offset + Vec3{0, 0, rng.next_float(-0.2f, 0.2f)};
    std::vector<Vec3> rim;
    for (int s = 0; s < spokes; ++s) {
      const float angle =
          (static_cast<float>(s) + 0.4f * rng.next_float()) * 2.0f * std::numbers::pi_v<float> / static_cast<float>(spokes);
      rim.push_back(offset + Vec3{std::cos(angle), std::sin(angle), rng.next_float(-0.2f, 0.2f)});
    }
    std::vector<PackedTriangle> fan;
    for (int s = 0; s < spokes; ++s)
      fan.push_back(pack({center, rim[s], rim[(s + 1) % spokes]}, static_cast<std::uint32_t>(s)));

    // From far above, so that the ray passes the fan's shadow well inside of the rim, whichever triangle it meets.
    for (int r = 0; r < 500; ++r, ++rays) {
      const Vec3 target =
          r % 8 == 0 ? center
                     : edge_point(center, rim[rng.next_below(static_cast<std::uint32_t>(spokes))], 0.1f * rng.next_float());
      const Vec3 org = offset + Vec3{rng.next_float(-0.5f, 0.5f), rng.next_float(-0.5f, 0.5f), rng.next_float(5, 50)};
      EXPECT_TRUE(hits_any(fan, {.org = org, .dir = target - org})) << i << ' ' << r;
    }
  }
  EXPECT_EQ(rays, 200'000u);
}

// An octahedron whose faces are split `levels` times, its vertices moved at random: closed, and around the origin.
std::vector<PackedTriangle> closed_mesh(std::uint64_t seed, int levels, Vec3 offset, std::vector<Vec3>& targets) {
  const int n = 1 << levels;
  // Vertices on the grid of the octahedron |x| + |y| + |z| = n; every face computes a vertex by the same function of its
  // integers.
  const auto vertex = [&](int x, int y, int z) {
    const auto key = static_cast<std::uint64_t>((x + n) * 4096 * 4096 + (y + n) * 4096 + (z + n));
    CounterRng rng(seed, key);
    const Vec3 direction{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    const float length = std::sqrt(dot(direction, direction));
    return offset + direction * (rng.next_float(0.8f, 1.2f) / length);
  };
  std::vector<PackedTriangle> triangles;
  const auto add = [&](Vec3 a, Vec3 b, Vec3 c) {
    triangles.push_back(pack({a, b, c}, static_cast<std::uint32_t>(triangles.size())));
    targets.insert(targets.end(), {a, edge_point(a, b, 0.5f), edge_point(b, c, 0.25f), edge_point(c, a, 0.75f)});
  };
  for (int octant = 0; octant < 8; ++octant) {
    const int sx = (octant & 1) != 0 ? -1 : 1, sy = (octant & 2) != 0 ? -1 : 1, sz = (octant & 4) != 0 ? -1 : 1;
    const auto at = [&](int i, int j) { return vertex(sx * i, sy * j, sz * (n - i - j)); };
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        add(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < n) add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
  }
  return triangles;
}

// Rays that start inside a closed mesh must leave it, however far from the origin of the coordinates it lies.
TEST(Watertight, ClosedMeshesDoNotLeak) {
  for (const float distance : {0.0f, 1.0f, 10.0f, 1000.0f, 100'000.0f}) {
    std::vector<Vec3> targets;
    const Vec3 offset = Vec3{1, -0.7f, 0.4f} * distance;
    const std::vector<PackedTriangle> mesh = closed_mesh(7, 3, offset, targets);
    for (std::uint64_t i = 0; i < 8'000; ++i) {
      CounterRng rng(6, i);
      const Vec3 org = offset + validation::random_in_cube(rng, 0.2f);
      const Vec3 target = targets[rng.next_below(static_cast<std::uint32_t>(targets.size()))];
      EXPECT_TRUE(hits_any(mesh, {.org = org, .dir = target - org})) << distance << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace accel
