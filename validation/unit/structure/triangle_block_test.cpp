#include "libaccel/structure/triangle_block.h"

#include <gtest/gtest.h>

#include <cmath>

namespace accel {
namespace {

TEST(TriangleBlock, LanesComeBack) {
  TriangleBlock block;
  for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane) {
    const auto f = static_cast<float>(10 * lane);
    block.set(lane, pack({{f, f + 1, f + 2}, {f + 3, f + 4, f + 5}, {f + 6, f + 7, f + 8}}, 100 + lane));
  }
  for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane) {
    const PackedTriangle t = block.packed(lane);
    EXPECT_EQ(t.prim_id(), 100 + lane);
    EXPECT_EQ(t.axis[1].word, 0u);
    for (int i = 0; i < 3; ++i) {
      const auto f = static_cast<float>(10 * lane + 3 * static_cast<std::uint32_t>(i));
      EXPECT_EQ(t.vertex(i), (Vec3{f, f + 1, f + 2}));
    }
    EXPECT_TRUE(block.has(lane));
  }
}

TEST(TriangleBlock, ClearedLanesHaveNothing) {
  TriangleBlock block;
  for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane) block.clear(lane);
  EXPECT_FALSE(block.has(2));
  EXPECT_EQ(block.prim_id[2], kNoHit);
  EXPECT_TRUE(std::isnan(block.packed(2).vertex(1).y));
}

}  // namespace
}  // namespace accel
