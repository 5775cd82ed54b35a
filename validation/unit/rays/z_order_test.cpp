#include "libaccel/rays/z_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "libaccel/core/morton.h"

namespace accel {
namespace {

TEST(ZOrder, SortsPixelsByCode) {
  for (const auto& [width, height] :
       std::vector<std::pair<std::uint32_t, std::uint32_t>>{{8, 8}, {5, 3}, {1, 17}, {33, 2}, {1, 1}}) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t pixel = 0; pixel < width * height; ++pixel) expected.push_back(pixel);
    std::ranges::sort(expected, {}, [w = width](std::uint32_t pixel) { return morton_2d(pixel % w, pixel / w); });
    EXPECT_TRUE(std::ranges::equal(z_order_pixels(width, height), expected)) << width << " x " << height;
  }
  EXPECT_TRUE(z_order_pixels(0, 5).empty());
}

}  // namespace
}  // namespace accel
