#include "libaccel/structure/indexed_block.h"
#include "validation/unit/special_floats.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

namespace accel {
namespace {

TEST(IndexedBlock, LanesHaveTheVerticesThatTheyName) {
  const Vec3 vertices[] = {{1, 2, 3}, {4, 5, 6}, {-0.0f, 8, 9}, {10, 11, 12}, {kNaN, kNaN, kNaN}, {}};
  const IndexedBlock block{{{0, 3, 2, 4}, {1, 2, 2, 4}, {2, 0, 1, 4}}, {70, 71, 72, kNoHit}};
  for (std::uint32_t lane = 0; lane < 3; ++lane) {
    EXPECT_TRUE(block.has(lane));
    const PackedTriangle t = block.packed(lane, vertices);
    EXPECT_EQ(t.prim_id(), 70 + lane);
    EXPECT_EQ(t.axis[1].word, 0u);
    EXPECT_EQ(t.axis[2].word, 0u);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(t.vertex(i), vertices[block.vertex[i][lane]]) << lane << ", vertex " << i;
  }
  EXPECT_TRUE(std::signbit(block.packed(0, vertices).vertex(2).x));
  EXPECT_FALSE(block.has(3));
  EXPECT_EQ(block.packed(3, vertices).prim_id(), kNoHit);
  EXPECT_TRUE(std::isnan(block.packed(3, vertices).vertex(1).z));
}

}  // namespace
}  // namespace accel
