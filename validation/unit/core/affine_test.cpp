#include "libaccel/core/affine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/float_bounds.h"

namespace accel {
namespace {

Affine random_map(std::uint64_t element, float spread) {
  CounterRng rng(7, element);
  Affine a;
  for (auto& row : a.m)
    for (float& x : row) x = rng.next_float(-1, 1) * std::pow(spread, rng.next_float(-1, 1));
  return a;
}

Vec3 random_point(CounterRng& rng) {
  const float x = rng.next_float(-9, 9), y = rng.next_float(-9, 9), z = rng.next_float(-9, 9);
  return {x, y, z};
}

TEST(Affine, IdentityKeepsEveryBit) {
  const auto map = inverse(Affine{});
  ASSERT_TRUE(map);
  const Ray ray{.org = {1e-40f, -3.7e17f, 0.1f}, .t_min = 0.5f, .dir = {1e-30f, 7, -2}, .t_max = 4};
  const Ray same = map->ray(ray);
  EXPECT_EQ(same.org, ray.org);
  EXPECT_EQ(same.dir, ray.dir);
  EXPECT_EQ(same.t_min, ray.t_min);
  EXPECT_EQ(same.t_max, ray.t_max);
}

TEST(Affine, PowersOfTwoAndPermutationsAreExact) {
  const Affine a{{{0, 0, -4, 1}, {0.5f, 0, 0, -2}, {0, 8, 0, 0.25f}}};
  const auto map = inverse(a);
  ASSERT_TRUE(map);
  EXPECT_EQ(map->point({5, 6, 7}), (Vec3{16, 0.84375f, -1}));
  EXPECT_EQ(map->vector({4, 1, 8}), (Vec3{2, 1, -1}));
  EXPECT_EQ(transform_point(a, Vec3d(map->point({5, 6, 7}))).to_float(), (Vec3{5, 6, 7}));
}

// The bounds of the header, with the inverse in double as the truth.
TEST(Affine, RoundedPointsAndVectorsStayWithinTheirBounds) {
  double largest_share = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const Affine a = random_map(i, i % 2 == 0 ? 1.0f : 30.0f);
    const auto map = inverse(a);
    if (!map) continue;
    const LinearInverse exact = *invert_linear(a);
    CounterRng rng(8, i);
    for (int n = 0; n < 20; ++n) {
      const Vec3 p = random_point(rng), q = map->point(p), v = map->vector(p);
      for (int r = 0; r < 3; ++r) {
        double point = 0, vector = 0, point_size = 0, vector_size = 0;
        for (int c = 0; c < 3; ++c) {
          const double d = double{p[c]} - a.m[c][3];
          point += exact.m[r][c] * d, vector += exact.m[r][c] * p[c];
          point_size += std::fabs(exact.m[r][c] * d), vector_size += std::fabs(exact.m[r][c] * p[c]);
        }
        EXPECT_LE(std::fabs(q[r] - point), gamma(kInverseRoundings) * point_size);
        EXPECT_LE(std::fabs(v[r] - vector), gamma(kInverseRoundings - 1) * vector_size);
        largest_share = std::fmax(largest_share, std::fabs(q[r] - point) / (gamma(kInverseRoundings) * point_size));
      }
    }
  }
  EXPECT_GT(largest_share, 0.3) << "the bound says nothing";
}

TEST(Affine, MapsWithoutAnInverseAreErrors) {
  const auto message = [](const Affine& a) {
    const auto map = inverse(a);
    return map ? std::string() : map.message();
  };
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  EXPECT_NE(message({{{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}}}), "");
  EXPECT_NE(message({{{1, 2, 3, 0}, {2, 4, 6, 0}, {0, 0, 1, 0}}}), "");
  EXPECT_NE(message({{{1, 1, 0, 0}, {1, 1 + 0x1p-20f, 0, 0}, {0, 0, 1, 0}}}), "") << "too nearly singular";
  EXPECT_NE(message({{{nan, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}), "");
  EXPECT_NE(message({{{1, 0, 0, inf}, {0, 1, 0, 0}, {0, 0, 1, 0}}}), "");
  EXPECT_NE(message({{{1, 0, 0, 0}, {0, 1, 0, 1e30f}, {0, 0, 1, 0}}}), "");
  EXPECT_NE(message({{{1e-30f, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}), "") << "the inverse is out of range";
  EXPECT_EQ(message({{{1e-10f, 0, 0, 0}, {0, 1e10f, 0, 0}, {0, 0, -1, 0}}}), "") << "uneven scales are no shear";
}

}  // namespace
}  // namespace accel
