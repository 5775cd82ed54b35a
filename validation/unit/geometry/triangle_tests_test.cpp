// What every triangle test of registry/method.h finds, and what it misses.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libaccel/geometry/baldwin_weber.h"
#include "libaccel/geometry/moeller_trumbore.h"
#include "libaccel/geometry/pluecker.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/geometry/woop.h"
#include "libaccel/registry/method.h"
#include "libaccel/trace/traverser.h"
#include "validation/stress/hostile_floats.h"

namespace accel {
namespace {

template <class Test>
bool hits(const PackedTriangle& triangle, const Ray& ray, Hit& hit) {
  Hit candidate;
  begin_hit(ray, hit);
  PackedTriangle read = triangle;
  if constexpr (PrecomputedTest<Test>) read = Test::prepare_triangle(triangle);
  if (!is_traceable(ray) || !Test::intersect(read, ray, Test::prepare(ray), candidate)) return false;
  candidate.prim_id = read.prim_id();
  return accept_hit(candidate, first_t(ray), hit);
}

template <class Test>
class TriangleTest : public testing::Test {};
using AllTests = testing::Types<Watertight, MoellerTrumbore, Woop, WoopKahan, Pluecker, BaldwinWeber>;
static_assert(std::is_same_v<TriangleTests::Apply<testing::Types>, AllTests>);
TYPED_TEST_SUITE(TriangleTest, AllTests);

TYPED_TEST(TriangleTest, FindsDistanceAndBarycentrics) {
  const PackedTriangle triangle = pack({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, 7);
  Hit hit;
  ASSERT_TRUE(hits<TypeParam>(triangle, {.org = {0.25f, 0.5f, 2}, .dir = {0, 0, -0.5f}}, hit));
  EXPECT_EQ(hit.t, 4.0f);
  EXPECT_EQ(hit.u, 0.25f);
  EXPECT_EQ(hit.v, 0.5f);
  EXPECT_EQ(hit.prim_id, 7u);
  ASSERT_TRUE(hits<TypeParam>(triangle, {.org = {0.25f, 0.5f, -2}, .dir = {0, 0, 1}}, hit)) << "from behind";
  EXPECT_EQ(hit.t, 2.0f);
  EXPECT_FALSE(hits<TypeParam>(triangle, {.org = {0.75f, 0.5f, 2}, .dir = {0, 0, -1}}, hit));
  EXPECT_FALSE(hits<TypeParam>(triangle, {.org = {-0.25f, 0.5f, 2}, .dir = {0, 0, -1}}, hit));
  EXPECT_FALSE(hits<TypeParam>(triangle, {.org = {0.25f, -0.5f, 2}, .dir = {0, 0, -1}}, hit));
  EXPECT_FALSE(hits<TypeParam>(triangle, {.org = {0.25f, 0.5f, 2}, .dir = {0, 0, 1}}, hit)) << "behind the ray";
}

// The axis of the normal, and its sign, make no difference.
TYPED_TEST(TriangleTest, InEveryPlaneAndDirection) {
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {1.0f, -1.0f}) {
      const int b = (axis + 1) % 3, c = (axis + 2) % 3;
      Triangle t{};
      t.v0[axis] = t.v1[axis] = t.v2[axis] = 3;
      t.v1[b] = t.v2[c] = 1;
      Ray ray{.org = {0, 0, 0}, .dir = {0, 0, 0}};
      ray.org[b] = 0.25f, ray.org[c] = 0.5f, ray.org[axis] = 3 + side, ray.dir[axis] = -side;
      Hit hit;
      ASSERT_TRUE(hits<TypeParam>(pack(t, 0), ray, hit)) << axis;
      EXPECT_EQ(hit.t, 1.0f) << axis;
      EXPECT_EQ(hit.u, 0.25f) << axis;
      EXPECT_EQ(hit.v, 0.5f) << axis;
    }
}

TYPED_TEST(TriangleTest, NaNAndInfinityMiss) {
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity()})
    for (int coordinate = 0; coordinate < 9; ++coordinate) {
      Triangle triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
      (&triangle.v0)[coordinate / 3][coordinate % 3] = bad;
      Hit hit;
      EXPECT_FALSE(hits<TypeParam>(pack(triangle, 0), {.org = {0.2f, 0.2f, 1}, .dir = {0.05f, 0.05f, -1}}, hit)) << coordinate;
    }
}

TYPED_TEST(TriangleTest, ParallelAndDegenerateMiss) {
  Hit hit;
  EXPECT_FALSE(hits<TypeParam>(pack({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, 0), {.org = {-1, 0.2f, 0}, .dir = {1, 0, 0}}, hit));
  EXPECT_FALSE(hits<TypeParam>(pack({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, 0), {.org = {0.5f, 0, 1}, .dir = {0, 0, -1}}, hit));
}

// Away from edges, and seen at no flat angle, all tests see the same triangle at the same place.
TYPED_TEST(TriangleTest, AgreesWithWatertightInsideTriangles) {
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    CounterRng rng(1, i);
    const Triangle t{validation::random_in_cube(rng, 1), validation::random_in_cube(rng, 1),
                     validation::random_in_cube(rng, 1)};
    const Vec3 normal = cross(t.v1 - t.v0, t.v2 - t.v0), org = validation::random_in_cube(rng, 3);
    const Vec3 dir = t.v0 * 0.3f + t.v1 * 0.3f + t.v2 * 0.4f - org;
    if (!(std::fabs(dot(normal, dir)) > 0.1f)) continue;
    Hit ours, reference;
    ASSERT_TRUE(hits<TypeParam>(pack(t, 0), {.org = org, .dir = dir}, ours)) << i;
    ASSERT_TRUE(hits<Watertight>(pack(t, 0), {.org = org, .dir = dir}, reference)) << i;
    EXPECT_NEAR(ours.t, reference.t, 1e-4f);
    EXPECT_NEAR(ours.u, reference.u, 1e-4f);
    EXPECT_NEAR(ours.v, reference.v, 1e-4f);
  }
}

// Rays at the edge that two triangles share, a fan of slivers among them, hit one of both: what those tests claim, and what the
// two others do not.
template <class Test>
std::size_t leaks() {
  std::size_t count = 0;
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    CounterRng rng(2, i);
    const Vec3 offset = validation::random_in_cube(rng, 100);
    const auto point = [&] { return offset + validation::random_in_cube(rng, 1); };
    const Vec3 a = point(), b = point(), org = point();
    const float s = rng.next_float();
    const Vec3 target = a * (1 - s) + b * s, dir = target - org;
    const Vec3 side = cross(b - a, dir);  // the triangles are on both sides of the edge, as the ray sees it
    const PackedTriangle left = pack({a, b, target + side}, 0), right = pack({b, a, target - side}, 1);
    Hit hit;
    const Ray ray{.org = org, .dir = dir};
    count += !hits<Test>(left, ray, hit) && !hits<Test>(right, ray, hit);
  }
  return count;
}

TEST(SharedEdges, LoseNoRay) {
  EXPECT_EQ(leaks<Watertight>(), 0u);
  EXPECT_EQ(leaks<Woop>(), 0u);
  EXPECT_EQ(leaks<WoopKahan>(), 0u);
  EXPECT_EQ(leaks<Pluecker>(), 0u);
  EXPECT_GT(leaks<MoellerTrumbore>(), 0u) << "the rays test nothing";
  EXPECT_GT(leaks<BaldwinWeber>(), 0u);
}

// a b - c d where the products agree in all bits that a float has: rounded products lose what is left, Kahan's do not.
TEST(KahanProducts, KeepWhatCancels) {
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    CounterRng rng(3, i);
    const float a = rng.next_float(1, 2), b = rng.next_float(1, 2), c = a * (1 + 0x1p-22f);
    const float d = static_cast<float>(static_cast<double>(a) * b / c);
    const double exact = static_cast<double>(a) * b - static_cast<double>(c) * d;  // both products fit
    EXPECT_NEAR(KahanProducts::difference(a, b, c, d), exact, 1.5 * 0x1p-23 * std::fabs(exact)) << i;
  }
  EXPECT_EQ(RoundedProducts::difference(1 + 0x1p-23f, 1 + 0x1p-23f, 1 + 0x1p-22f, 1), 0.0f);
  EXPECT_EQ(KahanProducts::difference(1 + 0x1p-23f, 1 + 0x1p-23f, 1 + 0x1p-22f, 1), 0x1p-46f);
}

}  // namespace
}  // namespace accel
