#include "libaccel/core/morton.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "libaccel/core/counter_rng.h"

namespace accel {
namespace {

// The definition: bit i of coordinate k becomes bit dimensions * i + k.
std::uint64_t interleave(const std::vector<std::uint32_t>& coordinates, std::size_t bits) {
  std::uint64_t code = 0;
  for (std::size_t i = 0; i < bits; ++i)
    for (std::size_t k = 0; k < coordinates.size(); ++k)
      code |= std::uint64_t{coordinates[k] >> i & 1u} << (i * coordinates.size() + k);
  return code;
}

TEST(Morton, InterleavesBits) {
  CounterRng rng(1, 0);
  for (int i = 0; i < 1000; ++i) {
    const auto x = static_cast<std::uint32_t>(rng.next_u64()), y = static_cast<std::uint32_t>(rng.next_u64());
    const auto z = static_cast<std::uint32_t>(rng.next_u64());
    EXPECT_EQ(morton_2d(x, y), interleave({x, y}, 32));
    EXPECT_EQ(gather_2(morton_2d(x, y)), x);
    EXPECT_EQ(gather_2(morton_2d(x, y) >> 1), y);
    EXPECT_EQ(morton_3d(x, y, z), interleave({x, y, z}, 21));
  }
}

TEST(Morton, CodesOfPointsFillTheirRange) {
  const Aabb box{{-1, -2, 3}, {1, 5, 4}};
  EXPECT_EQ(morton_30(box.lo, box), 0u);
  EXPECT_EQ(morton_30(box.hi, box), (1u << 30) - 1);
  EXPECT_EQ(morton_63(box.hi, box), (1ull << 63) - 1);
  EXPECT_EQ(morton_30({-100, -100, -100}, box), 0u) << "points outside count to the nearest slice";
  EXPECT_EQ(morton_30({100, 100, 100}, box), (1u << 30) - 1);
}

TEST(Morton, QuantizeIsMonotoneAndDefinedForEverything) {
  std::uint32_t last = 0;
  for (int i = 0; i <= 1000; ++i) {
    const std::uint32_t slice = quantize(static_cast<float>(i) / 1000, 0, 1, 10);
    EXPECT_GE(slice, last);
    last = slice;
  }
  EXPECT_EQ(last, 1023u);
  EXPECT_EQ(quantize(std::numeric_limits<float>::quiet_NaN(), 0, 1, 10), 0u);
  EXPECT_EQ(quantize(5, 5, 5, 10), 0u);
  EXPECT_EQ(quantize(std::numeric_limits<float>::infinity(), 0, 1, 10), 1023u);
  EXPECT_EQ(quantize(3e38f, -3e38f, 3e38f, 21), (1u << 21) - 1);
}

}  // namespace
}  // namespace accel
