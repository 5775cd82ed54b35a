#include "libaccel/core/vec3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "validation/stress/hostile_floats.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

TEST(Vec3, WorksByComponent) {
  const Vec3 a{1, 2, 3}, b{4, -5, 6};
  EXPECT_EQ(a + b, (Vec3{5, -3, 9}));
  EXPECT_EQ(a - b, (Vec3{-3, 7, -3}));
  EXPECT_EQ(a * b, (Vec3{4, -10, 18}));
  EXPECT_EQ(a * 2.0f, (Vec3{2, 4, 6}));
  EXPECT_EQ(2.0f * a, a * 2.0f);
  EXPECT_EQ(-a, (Vec3{-1, -2, -3}));
  EXPECT_EQ(dot(a, b), 12.0f);
  EXPECT_EQ(cross(Vec3{1, 0, 0}, Vec3{0, 1, 0}), (Vec3{0, 0, 1}));
}

TEST(Vec3, IndexesItsComponents) {
  Vec3 v{1, 2, 3};
  EXPECT_EQ(v[0], 1.0f);
  EXPECT_EQ(v[1], 2.0f);
  EXPECT_EQ(v[2], 3.0f);
  v[0] = 7, v[1] = 8, v[2] = 9;
  EXPECT_EQ(v, (Vec3{7, 8, 9}));
}

// The watertight test relies on products that are rounded before they are subtracted.
TEST(Vec3, CrossProductIsNotContracted) {
  for (std::uint64_t i = 0; i < 10000; ++i) {
    CounterRng rng(1, i);
    const Vec3 a = validation::random_in_cube(rng, 1), b = validation::random_in_cube(rng, 1);
    EXPECT_EQ(cross(a, a), (Vec3{0, 0, 0}));
    EXPECT_EQ(cross(a, b), -cross(b, a));
  }
}

TEST(Vec3, MinAndMaxReturnTheSecondArgumentForNaN) {
  EXPECT_EQ(min_of(kNaN, 1.0f), 1.0f);
  EXPECT_EQ(max_of(kNaN, 1.0f), 1.0f);
  EXPECT_TRUE(std::isnan(min_of(1.0f, kNaN)));
  EXPECT_TRUE(std::isnan(max_of(1.0f, kNaN)));
  EXPECT_TRUE(std::signbit(min_of(0.0f, -0.0f)));
  EXPECT_FALSE(std::signbit(min_of(-0.0f, 0.0f)));
  EXPECT_EQ(min_of(Vec3{1, 5, 3}, Vec3{4, 2, 3}), (Vec3{1, 2, 3}));
  EXPECT_EQ(max_of(Vec3{1, 5, 3}, Vec3{4, 2, 3}), (Vec3{4, 5, 3}));
}

TEST(Vec3, LargestAxisPrefersTheLowestOnTies) {
  EXPECT_EQ(largest_axis({3, 1, 2}), 0);
  EXPECT_EQ(largest_axis({1, -3, 2}), 1);
  EXPECT_EQ(largest_axis({1, 2, -3}), 2);
  EXPECT_EQ(largest_axis({1, -1, 1}), 0);
  EXPECT_EQ(largest_axis({0, -1, 1}), 1);
  EXPECT_EQ(largest_axis({0, 0, 0}), 0);
  EXPECT_EQ(largest_axis({-0.0f, 0.0f, std::numeric_limits<float>::denorm_min()}), 2);
}

}  // namespace
}  // namespace accel
