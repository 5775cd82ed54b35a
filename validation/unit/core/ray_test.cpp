#include "libaccel/core/ray.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libaccel/core/float_bounds.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

const float kNaN = std::nanf("");
const Ray kGood{.org = {1, 2, 3}, .t_min = 0, .dir = {0, 0, 1}, .t_max = 10};

TEST(Ray, IsUnboundedByDefault) {
  const Ray ray{.org = {}, .dir = {1, 0, 0}};
  EXPECT_EQ(ray.t_min, 0.0f);
  EXPECT_EQ(ray.t_max, kInfinity);
  EXPECT_TRUE(is_traceable(ray));
}

TEST(Ray, OriginAndDirectionMustBeInRange) {
  for (int axis = 0; axis < 3; ++axis)
    for (const float bad : {kNaN, kInfinity, -kInfinity, next_up(kMaxCoordinate), -next_up(kMaxCoordinate)}) {
      Ray ray = kGood;
      ray.org[axis] = bad;
      EXPECT_FALSE(is_traceable(ray)) << axis << ' ' << bad;
      ray = kGood;
      ray.dir[axis] = bad;
      EXPECT_FALSE(is_traceable(ray)) << axis << ' ' << bad;
    }
  Ray far = kGood;
  far.org = {kMaxCoordinate, -kMaxCoordinate, kMaxCoordinate};
  EXPECT_TRUE(is_traceable(far));
}

TEST(Ray, DirectionMustNotBeZero) {
  Ray ray = kGood;
  ray.dir = {0.0f, -0.0f, 0.0f};
  EXPECT_FALSE(is_traceable(ray));
  ray.dir.y = std::numeric_limits<float>::denorm_min();
  EXPECT_TRUE(is_traceable(ray));
}

TEST(Ray, IntervalMustHoldAPoint) {
  const auto with_interval = [](float t_min, float t_max) {
    Ray ray = kGood;
    ray.t_min = t_min, ray.t_max = t_max;
    return is_traceable(ray);
  };
  EXPECT_TRUE(with_interval(1, 1));
  EXPECT_TRUE(with_interval(0, 0));
  EXPECT_TRUE(with_interval(-kInfinity, kInfinity));
  EXPECT_TRUE(with_interval(-2, 0));
  EXPECT_FALSE(with_interval(-2, -1));
  EXPECT_FALSE(with_interval(1, next_down(1.0f)));
  EXPECT_FALSE(with_interval(kNaN, 1));
  EXPECT_FALSE(with_interval(0, kNaN));
}

}  // namespace
}  // namespace accel
