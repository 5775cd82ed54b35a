#include "libaccel/trace/bvh8_ray.h"

#include <gtest/gtest.h>

#include <limits>

#include "libaccel/core/counter_rng.h"
#include "validation/unit/build/test_meshes.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

constexpr float kMax = std::numeric_limits<float>::max();

Bvh8Node node_of(const Aabb& box) {
  Bvh8Node node{};
  for (std::uint32_t c = 0; c < kBvh8Arity; ++c) node.set_child(c, block_ref(c, 1), box);
  return node;
}

bool enters(const Ray& ray, const Aabb& box, float t_max = kMax) {
  float t_near;
  return Bvh8Ray<>::prepare(ray, ray.t_min).enters(node_of(box), 3, scaled_end<>(t_max), t_near);
}

const Aabb kUnitBox{{0, 0, 0}, {1, 1, 1}};

TEST(Bvh8Ray, EntersWhatItMeets) {
  EXPECT_TRUE(enters({{-1, 0.5f, 0.5f}, 0, {1, 0, 0}}, kUnitBox));
  EXPECT_FALSE(enters({{-1, 1.5f, 0.5f}, 0, {1, 0, 0}}, kUnitBox));
  EXPECT_FALSE(enters({{-1, 0.5f, 0.5f}, 0, {-1, 0, 0}}, kUnitBox));
  EXPECT_TRUE(enters({{0.5f, 0.5f, 0.5f}, 0, {-1, 2, 0.1f}}, kUnitBox));
  float t_near = 0;
  EXPECT_TRUE(Bvh8Ray<>::prepare({{-1, -2, -3}, 0, {1, 1, 1}}, 0).enters(node_of({{0, 0, 0}, {5, 5, 5}}), 0, kMax, t_near));
  EXPECT_EQ(t_near, 3.0f);
}

TEST(Bvh8Ray, TheIntervalIsClosed) {
  const Ray ray{{-1, 0.5f, 0.5f}, 0, {1, 0, 0}};
  EXPECT_TRUE(enters(ray, kUnitBox, 1.0f));
  EXPECT_FALSE(enters(ray, kUnitBox, 0.999f));
  EXPECT_TRUE(enters({ray.org, 2.0f, ray.dir}, kUnitBox));
  EXPECT_FALSE(enters({ray.org, 2.001f, ray.dir}, kUnitBox));
}

TEST(Bvh8Ray, EntersNoPlaceWithoutAChild) {
  const Aabb none{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (const Vec3 dir :
       {Vec3{1, 2, 3}, Vec3{-1, 0, 0}, Vec3{0, -0.0f, 1}, Vec3{1e-44f, -1e-44f, 0}, Vec3{1e18f, -1e18f, 1e18f}})
    for (const Vec3 org : {Vec3{0, 0, 0}, Vec3{-1e18f, 1e18f, 0}})
      for (const float t_max : {0.0f, 1.0f, kMax}) EXPECT_FALSE(enters({org, 0, dir}, none, t_max));
}

// Rays in the planes of a box, and along its edges, where distances are NaN.
TEST(Bvh8Ray, PlanesThroughTheOriginRestrictNothing) {
  for (const float y : {0.0f, 0.5f, 1.0f})
    for (const float z : {0.0f, 0.5f, 1.0f})
      for (const float zero : {0.0f, -0.0f}) {
        EXPECT_TRUE(enters({{-1, y, z}, 0, {1, zero, zero}}, kUnitBox)) << y << ' ' << z;
        EXPECT_TRUE(enters({{y, -1, z}, 0, {zero, 1, -zero}}, kUnitBox)) << y << ' ' << z;
        EXPECT_TRUE(enters({{z, y, 3}, 0, {zero, zero, -1}}, kUnitBox)) << y << ' ' << z;
      }
}

// Whatever the pair test of trace/box_pair.h enters is entered.
TEST(Bvh8Ray, MissesNothingThatThePairTestEnters) {
  std::size_t entered = 0;
  for (std::uint32_t i = 0; i < 200000; ++i) {
    CounterRng rng(3, i);
    const auto coordinate = [&] { return static_cast<float>(rng.next_below(9)) / 4 - 1; };
    const auto point = [&] {
      const float x = coordinate(), y = coordinate(), z = coordinate();
      return Vec3{x, y, z};
    };
    Aabb box;
    box.extend(point()), box.extend(point());
    const Ray ray{point(), 0, i % 2 == 0 ? point() : test::random_point(rng)};
    if (!is_traceable(ray)) continue;
    Bvh2Node pair{};
    pair.set_bounds(0, box), pair.set_bounds(1, box);
    const float t_max = i % 3 == 0 ? kMax : rng.next_float();
    const bool expected = ScalarBoxPairTest::prepare(ray, 0).intersect(pair, t_max).mask != 0;
    entered += expected;
    if (expected) {
      EXPECT_TRUE(enters(ray, box, t_max)) << i;
    }
  }
  EXPECT_GT(entered, 10000u);
}

}  // namespace
}  // namespace accel
