#include "libaccel/core/counter_rng.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace accel {
namespace {

TEST(CounterRng, DependsOnSeedElementAndStreamOnly) {
  EXPECT_EQ(CounterRng(1, 2, 3).next_u64(), CounterRng(1, 2, 3).next_u64());
  std::set<std::uint64_t> first;
  for (std::uint64_t seed = 0; seed < 10; ++seed)
    for (std::uint64_t element = 0; element < 10; ++element)
      for (std::uint64_t stream = 0; stream < 10; ++stream) first.insert(CounterRng(seed, element, stream).next_u64());
  EXPECT_EQ(first.size(), 1000u);
}

TEST(CounterRng, IsUniformAcrossElements) {
  // The first number of each of many neighbouring elements: mean 1/2 and variance 1/12, within five standard errors.
  constexpr int kCount = 1 << 16;
  double sum = 0, sum_of_squares = 0;
  for (int i = 0; i < kCount; ++i) {
    const double x = CounterRng(7, static_cast<std::uint64_t>(i)).next_double();
    ASSERT_TRUE(x >= 0 && x < 1);
    sum += x, sum_of_squares += x * x;
  }
  const double mean = sum / kCount, variance = sum_of_squares / kCount - mean * mean;
  EXPECT_NEAR(mean, 0.5, 5 * std::sqrt(1 / 12.0 / kCount));
  EXPECT_NEAR(variance, 1 / 12.0, 5 * std::sqrt(1 / 180.0 / kCount));
}

TEST(CounterRng, RangesHold) {
  CounterRng rng(3, 0);
  std::set<std::uint32_t> seen;
  for (int i = 0; i < 10000; ++i) {
    const float f = rng.next_float();
    ASSERT_TRUE(f >= 0 && f < 1);
    const float g = rng.next_float(-2, 5);
    ASSERT_TRUE(g >= -2 && g <= 5);
    const std::uint32_t k = rng.next_below(7);
    ASSERT_LT(k, 7u);
    seen.insert(k);
  }
  EXPECT_EQ(seen.size(), 7u);
}

}  // namespace
}  // namespace accel
