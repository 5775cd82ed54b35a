#include "libaccel/geometry/clip_triangle.h"

#include <gtest/gtest.h>

#include <cmath>

#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

Vec3 wide_point(CounterRng& rng, int exponents) {
  const auto coordinate = [&] {
    const float x = rng.next_float(-1, 1);
    return std::ldexp(x, static_cast<int>(rng.next_below(static_cast<std::uint32_t>(2 * exponents + 1))) - exponents);
  };
  const float x = coordinate(), y = coordinate(), z = coordinate();
  return {x, y, z};
}

// Whether the point (1 - s) p + s q, at which the edge meets the plane, lies in the box: exactly, for long double holds the
// products of doubles that hold floats well enough to see an error of a float's thousandth.
bool crossing_is_inside(Vec3 p, Vec3 q, int axis, float position, const Aabb& box) {
  const long double height = static_cast<long double>(q[axis]) - p[axis];
  for (int a = 0; a < 3; ++a) {
    if (a == axis) continue;
    const long double x =
        p[a] + (static_cast<long double>(position) - p[axis]) * (static_cast<long double>(q[a]) - p[a]) / height;
    const long double slack = 1e-17L * (std::fabs(p[a]) + std::fabs(q[a]));
    if (!(x >= box.lo[a] - slack && x <= box.hi[a] + slack)) return false;
  }
  return box.lo[axis] <= position && position <= box.hi[axis];
}

class ClipTriangle : public testing::TestWithParam<int> {};  // the parameter: how widely exponents vary

TEST_P(ClipTriangle, SectionsContainTheCrossings) {
  for (std::uint32_t i = 0; i < 20000; ++i) {
    CounterRng rng(1, i);
    const Triangle t{wide_point(rng, GetParam()), wide_point(rng, GetParam()), wide_point(rng, GetParam())};
    const int axis = static_cast<int>(rng.next_below(3));
    const Aabb box = t.bounds();
    const float position = box.lo[axis] + rng.next_float() * (box.hi[axis] - box.lo[axis]);
    const Aabb section = TriangleSlicer(t, axis).section(position).aabb();
    const Vec3 v[3] = {t.v0, t.v1, t.v2};
    for (int e = 0; e < 3; ++e) {
      const Vec3 p = v[e], q = v[(e + 1) % 3];
      if ((p[axis] < position && position < q[axis]) || (q[axis] < position && position < p[axis])) {
        EXPECT_TRUE(crossing_is_inside(p, q, axis, position, section)) << "triangle " << i;
      }
    }
  }
}

TEST_P(ClipTriangle, PartsCoverTheBoxAndMeetInThePlane) {
  for (std::uint32_t i = 0; i < 20000; ++i) {
    CounterRng rng(2, i);
    const Triangle t{wide_point(rng, GetParam()), wide_point(rng, GetParam()), wide_point(rng, GetParam())};
    const int axis = static_cast<int>(rng.next_below(3));
    const Aabb box = t.bounds();
    const float position = box.lo[axis] + rng.next_float() * (box.hi[axis] - box.lo[axis]);
    const TriangleParts parts = split_bounds(t, Box4::of(box), axis, position);
    const Aabb left = parts.left.aabb(), right = parts.right.aabb();
    EXPECT_TRUE(box.contains(left) && box.contains(right));
    EXPECT_LE(left.hi[axis], position);
    EXPECT_GE(right.lo[axis], position);
    for (const Vec3 v : {t.v0, t.v1, t.v2}) {
      EXPECT_TRUE(v[axis] > position || left.contains(Aabb{v, v}));
      EXPECT_TRUE(v[axis] < position || right.contains(Aabb{v, v}));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Exponents, ClipTriangle, testing::Values(0, 8, 40));

TEST(SplitBounds, AreTight) {
  const Triangle t{{0, 0, 0}, {4, 0, 0}, {0, 4, 8}};
  const TriangleParts parts = split_bounds(t, Box4::of(t.bounds()), 0, 2.0f);
  EXPECT_NEAR(parts.right.aabb().hi.y, 2.0, 1e-5);
  EXPECT_NEAR(parts.right.aabb().hi.z, 4.0, 1e-5);
  EXPECT_EQ(parts.left.aabb().hi.x, 2.0f);
  EXPECT_EQ(parts.left.aabb().hi.z, 8.0f);
}

TEST(SplitBounds, FlatTrianglesStayFlat) {
  const Triangle t{{0, 0.1f, 0}, {3, 0.1f, 0}, {0, 0.1f, 7}};
  const TriangleParts parts = split_bounds(t, Box4::of(t.bounds()), 2, 1.7f);
  EXPECT_EQ(parts.left.aabb().extent().y, 0.0f);
  EXPECT_EQ(parts.right.aabb().extent().y, 0.0f);
}

TEST(SplitBounds, PartsOutsideOfTheBoxAreEmpty) {
  // The triangle reaches beyond the plane, but its part in the box does not.
  const Triangle t{{0, 0, 0}, {4, 4, 0}, {0, 4, 0}};
  const TriangleParts parts = split_bounds(t, Box4::of({{0, 0, 0}, {4, 1, 0}}), 0, 3.0f);
  EXPECT_FALSE(parts.left.empty());
  EXPECT_TRUE(parts.right.empty());
}

TEST(ClippedPolygon, AreasOfKnownParts) {
  const Triangle t{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  ClippedPolygon whole(t);
  EXPECT_DOUBLE_EQ(whole.area(), 8.0);
  whole.clip({{-1, -1, -1}, {2, 2, 1}});
  EXPECT_DOUBLE_EQ(whole.area(), 4.0);
  EXPECT_TRUE(whole.is_inside({{0, 0, 0}, {2, 2, 0}}));
  whole.clip({{3, 3, -1}, {4, 4, 1}});
  EXPECT_EQ(whole.area(), 0.0);
}

TEST(ClippedPolygon, PartsOfAGridAddUp) {
  for (std::uint32_t i = 0; i < 200; ++i) {
    CounterRng rng(3, i);
    const Triangle t{test::random_point(rng), test::random_point(rng), test::random_point(rng)};
    double sum = 0;
    for (int cell = 0; cell < 64; ++cell) {
      const Vec3 lo{-1 + 0.5f * static_cast<float>(cell & 3), -1 + 0.5f * static_cast<float>(cell >> 2 & 3),
                    -1 + 0.5f * static_cast<float>(cell >> 4)};
      ClippedPolygon part(t);
      part.clip({lo, lo + Vec3{0.5f, 0.5f, 0.5f}});
      sum += part.area();
    }
    EXPECT_NEAR(sum, ClippedPolygon(t).area(), 1e-12);
  }
}

// bounds_of_side() says what cutting there would leave, to the bit.
TEST(ClippedPolygon, BoundsOfASideAreThoseOfTheCutPolygon) {
  const auto whole = [](const ClippedPolygon& polygon) { return polygon.bounds_of_side(0, -100, 1); };
  for (std::uint32_t i = 0; i < 2000; ++i) {
    CounterRng rng(4, i);
    ClippedPolygon polygon({test::random_point(rng), test::random_point(rng), test::random_point(rng)});
    polygon.clip(2, rng.next_float(-1, 0), rng.next_float(0, 1));
    const int axis = static_cast<int>(rng.next_below(3));
    const double position = rng.next_float(-1, 1);
    ClippedPolygon lower = polygon, upper = polygon;
    lower.clip(axis, -100, position), upper.clip(axis, position, 100);
    const ClippedPolygon::Bounds expected[] = {whole(lower), whole(upper)};
    const ClippedPolygon::Bounds found[] = {polygon.bounds_of_side(axis, position, -1),
                                            polygon.bounds_of_side(axis, position, 1)};
    for (int c = 0; c < 2; ++c)
      for (int a = 0; a < 3; ++a) {
        EXPECT_EQ(found[c].lo[a], expected[c].lo[a]);
        EXPECT_EQ(found[c].hi[a], expected[c].hi[a]);
      }
  }
}

}  // namespace
}  // namespace accel
