// Float4Sse and its portable twin, operation by operation, bit by bit.
#include "libaccel/core/float4_simd.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <vector>

namespace accel {
namespace {

// Ordinary values, zeros of both signs, denormals, infinities and NaN.
std::vector<float> values() {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  return {0.0f, -0.0f, 1.0f, -1.5f, 0.1f, 3e38f, -3e38f, 1e-40f, -1e-45f, inf, -inf, nan};
}

void expect_same(float a, float b) {
  EXPECT_TRUE((std::isnan(a) && std::isnan(b)) || std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b))
      << a << ' ' << b;
}
void expect_same(Vec3 a, Vec3 b) { expect_same(a.x, b.x), expect_same(a.y, b.y), expect_same(a.z, b.z); }

TEST(Float4, TwinsAgreeOnAllPairs) {
  for (const float x : values())
    for (const float y : values()) {
      const Vec3 p{x, y, 2.0f}, q{y, x, 0.3f};
      const Float4 a = Float4::of(p), b = Float4::of(q);
      const Float4Scalar c = Float4Scalar::of(p), d = Float4Scalar::of(q);
      expect_same((a + b).xyz(), (c + d).xyz());
      expect_same((a - b).xyz(), (c - d).xyz());
      expect_same((a * b).xyz(), (c * d).xyz());
      expect_same(min_of(a, b).xyz(), min_of(c, d).xyz());
      expect_same(max_of(a, b).xyz(), max_of(c, d).xyz());
      expect_same(a.yzx().xyz(), c.yzx().xyz());
      expect_same(a.sum_xyz(), c.sum_xyz());
      for (int lane = 0; lane < 3; ++lane) expect_same(a.with_lane(lane, y).xyz(), c.with_lane(lane, y).xyz());
      EXPECT_EQ(xyz_less_equal(a, b), xyz_less_equal(c, d));
    }
}

TEST(Float4, LoadClearsTheFourthLane) {
  alignas(16) float memory[4] = {1, 2, 3, 4};
  std::int32_t lanes[4];
  Float4::load_xyz(*reinterpret_cast<const Vec3*>(memory)).truncate_to(lanes);
  EXPECT_EQ(lanes[2], 3);
  EXPECT_EQ(lanes[3], 0);
}

TEST(Float4, TruncatesTowardsZero) {
  std::int32_t lanes[4];
  Float4::of({1.9f, -1.9f, 63.0f}).truncate_to(lanes);
  EXPECT_EQ(lanes[0], 1);
  EXPECT_EQ(lanes[1], -1);
  EXPECT_EQ(lanes[2], 63);
}

TEST(Box4, EmptyAndAreas) {
  const Float4 one = Float4::splat(1.0f);
  Box4 box;
  EXPECT_TRUE(box.empty());
  EXPECT_EQ(box.half_area(one), 0.0f);
  box.extend(Float4::of({1, 2, 3}));
  EXPECT_FALSE(box.empty());
  box.extend(Float4::of({0, 0, 0}));
  EXPECT_EQ(box.half_area(one), 1.0f * 2 + 2 * 3 + 3 * 1);
  EXPECT_EQ(box.half_area(Float4::splat(0.5f)), 0.25f * 11);
}

}  // namespace
}  // namespace accel
