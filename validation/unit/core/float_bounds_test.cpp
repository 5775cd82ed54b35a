#include "libaccel/core/float_bounds.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "validation/stress/hostile_floats.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

TEST(FloatBounds, GammaIsHighams) {
  EXPECT_EQ(kUnitRoundoff, 0x1p-24f);
  for (const int n : {1, 3, 5, 8, 100}) {
    const double exact = n * 0x1p-24 / (1 - n * 0x1p-24);
    EXPECT_NEAR(gamma(n), exact, exact * 0x1p-22);
  }
}

// The claim that gamma() stands for: n rounded multiplications are within gamma(n) of the exact product.
TEST(FloatBounds, GammaBoundsRoundedProducts) {
  for (std::uint64_t i = 0; i < 10000; ++i) {
    CounterRng rng(1, i);
    float rounded = 1.0f + rng.next_float();
    long double exact = rounded;
    for (int n = 1; n <= 8; ++n) {
      const float factor = 0.75f + 0.5f * rng.next_float();
      rounded *= factor, exact *= factor;
      ASSERT_LE(std::fabs(static_cast<double>(rounded - exact)), gamma(n) * std::fabs(static_cast<double>(exact)));
    }
  }
}

TEST(FloatBounds, NeighboursAreAdjacent) {
  EXPECT_EQ(next_up(1.0f), 1.0f + 0x1p-23f);
  EXPECT_EQ(next_down(1.0f), 1.0f - 0x1p-24f);
  EXPECT_EQ(next_up(0.0f), std::numeric_limits<float>::denorm_min());
  EXPECT_EQ(next_up(-0.0f), std::numeric_limits<float>::denorm_min());
  EXPECT_EQ(next_up(kInfinity), kInfinity);
  EXPECT_EQ(next_down(-kInfinity), -kInfinity);
  EXPECT_EQ(next_up(std::numeric_limits<float>::max()), kInfinity);
  for (std::uint64_t i = 0; i < 10000; ++i) {
    CounterRng rng(2, i);
    const float x = validation::random_over_exponents(rng, -140, 126);
    EXPECT_EQ(next_down(next_up(x)), x);
    EXPECT_EQ(std::abs(std::bit_cast<std::int32_t>(next_up(x)) - std::bit_cast<std::int32_t>(x)), 1);
  }
}

TEST(FloatBounds, NeighboursAreThoseOfNextafter) {
  const auto expect_same = [](float x) {
    EXPECT_EQ(std::bit_cast<std::uint32_t>(next_up(x)), std::bit_cast<std::uint32_t>(std::nextafter(x, kInfinity))) << x;
    EXPECT_EQ(std::bit_cast<std::uint32_t>(next_down(x)), std::bit_cast<std::uint32_t>(std::nextafter(x, -kInfinity))) << x;
  };
  using Limits = std::numeric_limits<float>;
  for (const float x : {0.0f, Limits::denorm_min(), Limits::min(), 1.0f, Limits::max(), kInfinity})
    expect_same(x), expect_same(-x);
  for (std::uint64_t i = 0; i < 100000; ++i) {
    const auto x = std::bit_cast<float>(static_cast<std::uint32_t>(CounterRng(4, i).next_u64()));
    if (!std::isnan(x)) expect_same(x);
  }
  EXPECT_TRUE(std::isnan(next_up(Limits::quiet_NaN())) && std::isnan(next_down(Limits::quiet_NaN())));
  static_assert(next_up(1.0f) == 1.0f + 0x1p-23f);
}

TEST(FloatBounds, DirectedRoundingIsTheTightest) {
  for (std::uint64_t i = 0; i < 10000; ++i) {
    CounterRng rng(3, i);
    const double x = std::ldexp(rng.next_double() - 0.5, static_cast<int>(rng.next_below(240)) - 120);
    const float down = round_down(x), up = round_up(x);
    EXPECT_LE(static_cast<double>(down), x);
    EXPECT_GE(static_cast<double>(up), x);
    EXPECT_GT(static_cast<double>(next_up(down)), x);
    EXPECT_LT(static_cast<double>(next_down(up)), x);
  }
  EXPECT_EQ(round_down(0.5), 0.5f);
  EXPECT_EQ(round_up(0.5), 0.5f);
  EXPECT_EQ(round_up(1e300), kInfinity);
  EXPECT_EQ(round_down(1e300), std::numeric_limits<float>::max());
}

}  // namespace
}  // namespace accel
