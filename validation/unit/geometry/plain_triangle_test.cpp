// A quick look must never call plain what the exact predicates skip, and should call most triangles plain.
#include "libaccel/geometry/plain_triangle.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libaccel/core/counter_rng.h"
#include "libaccel/geometry/mesh_facts.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

bool is_plain(const Triangle& t) { return is_plain_triangle(Float4::of(t.v0), Float4::of(t.v1), Float4::of(t.v2)); }

// Whether the quick look is right, if it says anything.
bool agrees(const Triangle& t) { return !is_plain(t) || (is_in_range(t) && !is_zero_area(t)); }

Vec3 random_point(CounterRng& rng, float scale) {
  const float x = rng.next_float(-1, 1), y = rng.next_float(-1, 1), z = rng.next_float(-1, 1);
  return scale * Vec3{x, y, z};
}

float random_scale(CounterRng& rng) { return std::ldexp(1.0f, static_cast<int>(rng.next_float(-149, 61))); }

TEST(PlainTriangle, PointsOnALineAreNotPlain) {
  for (std::uint64_t i = 0; i < 100000; ++i) {
    CounterRng rng(1, i);
    // Small whole numbers times powers of two: the corners are on a line exactly, near the origin or far from it.
    const float scale = random_scale(rng);
    const auto whole = [&] { return std::floor(rng.next_float(-100, 100)); };
    const Vec3 base{whole(), whole(), whole()}, step{whole(), whole(), whole()};
    const float s = whole(), t = whole();
    const Triangle triangle{scale * base, scale * (base + s * step), scale * (base + t * step)};
    EXPECT_TRUE(agrees(triangle)) << i;
    EXPECT_FALSE(is_in_range(triangle) && is_plain(triangle)) << i;
  }
}

// Within an ulp or a few of a line, where single precision cannot tell.
TEST(PlainTriangle, NearlyOnALineNeverContradictsTheExactAnswer) {
  for (std::uint64_t i = 0; i < 200000; ++i) {
    CounterRng rng(2, i);
    const float scale = random_scale(rng);
    const Vec3 a = random_point(rng, scale), b = random_point(rng, scale);
    Vec3 c = a + rng.next_float(0, 1) * (b - a);
    if (i % 3 != 0) c[static_cast<int>(i % 3)] = std::nextafter(c[static_cast<int>(i % 3)], scale);
    EXPECT_TRUE(agrees({a, b, c})) << i;
    EXPECT_TRUE(agrees({a, c, c})) << i;
  }
}

TEST(PlainTriangle, AnyExponentsNeverContradictTheExactAnswer) {
  for (std::uint64_t i = 0; i < 200000; ++i) {
    CounterRng rng(3, i);
    Triangle t;
    for (Vec3* v : {&t.v0, &t.v1, &t.v2})
      for (int a = 0; a < 3; ++a)
        (*v)[a] = i % 2 == 0 && rng.next_float(0, 1) < 0.3f ? 0.0f : rng.next_float(-2, 2) * random_scale(rng);
    EXPECT_TRUE(agrees(t)) << i;
  }
}

TEST(PlainTriangle, WhatIsOutOfRangeIsNotPlain) {
  const float beyond = std::nextafter(kMaxCoordinate, kInfinity);
  for (const float bad : {kNaN, kInfinity, -kInfinity, beyond, -beyond, 3e38f})
    for (int corner = 0; corner < 3; ++corner)
      for (int axis = 0; axis < 3; ++axis) {
        Triangle t{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        (corner == 0 ? t.v0 : corner == 1 ? t.v1 : t.v2)[axis] = bad;
        EXPECT_FALSE(is_plain(t)) << bad << ' ' << corner << ' ' << axis;
      }
}

TEST(PlainTriangle, MostTrianglesArePlain) {
  int plain = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    CounterRng rng(4, i);
    const Vec3 p = random_point(rng, 1);
    plain += is_plain({p, p + random_point(rng, 1e-3f), p + random_point(rng, 1e-3f)}) ? 1 : 0;
  }
  EXPECT_GE(plain, 990);
}

}  // namespace
}  // namespace accel
