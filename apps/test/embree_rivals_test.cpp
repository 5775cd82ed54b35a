#include "apps/common/embree_rivals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace accel::apps {
namespace {

TEST(ByTiles, RaysComeByTilesOfPixelsAndInOrderWithinAPixel) {
  constexpr std::uint32_t kWidth = 8, kHeight = 4, kSamples = 2;
  RaySet set{Buffer<Ray>(kWidth * kHeight * kSamples), Buffer<std::uint32_t>(kWidth * kHeight * kSamples)};
  for (std::uint32_t i = 0; i < set.size(); ++i)
    set.pixel[i] = i / kSamples, set.rays[i] = {.org = {static_cast<float>(i), 0, 0}, .dir = {0, 0, 1}};
  const Buffer<Ray> rays = by_tiles(set, kWidth);
  ASSERT_EQ(rays.size(), set.size());
  std::vector<std::uint32_t> first_tile, all;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto number = static_cast<std::uint32_t>(rays[i].org.x);
    all.push_back(number);
    if (i < 4 * kSamples) first_tile.push_back(number);
  }
  // The pixels (0, 0), (1, 0), (0, 1) and (1, 1).
  EXPECT_EQ(first_tile, (std::vector<std::uint32_t>{0, 1, 2, 3, 16, 17, 18, 19}));
  std::ranges::sort(all);
  for (std::uint32_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i], i);
}

TEST(ByTiles, RaysWithoutPixelsStayAsTheyAre) { EXPECT_EQ(by_tiles({Buffer<Ray>(5), {}}, 8).size(), 0u); }

}  // namespace
}  // namespace accel::apps
