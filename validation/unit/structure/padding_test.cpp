#include "libaccel/structure/padding.h"

#include <gtest/gtest.h>

namespace accel {
namespace {

TEST(Padding, GrowsWithTheExtentAndIsNeverZero) {
  const Vec3d pad = cell_padding({{0, 0, 5}, {1, 2, 5}});
  const auto extents = static_cast<double>(gamma(16)), coordinates = static_cast<double>(gamma(2));
  EXPECT_EQ(pad.x, extents * (1 + 4 * 2.0) + coordinates * 1);
  EXPECT_EQ(pad.y, extents * (2 + 4 * 2.0) + coordinates * 2);
  EXPECT_EQ(pad.z, extents * (0 + 4 * 2.0) + coordinates * 5);
}

TEST(Padding, NothingHasNone) {
  const Vec3d pad = cell_padding(Aabb{});
  EXPECT_EQ(pad.x, 0);
  EXPECT_EQ(pad.y, 0);
  EXPECT_EQ(pad.z, 0);
}

// Flat boxes, and boxes whose pad is lost beside their coordinates.
TEST(Padding, PaddedBoxesAreStrictlyLarger) {
  const Aabb boxes[] = {{{0, 0, 0}, {1, 1, 0}},
                        {{1e18f, -1e-3f, 0}, {1e18f, 1e-3f, 1e-3f}},
                        {{0, 0, 1e-40f}, {1e-42f, 0, 1e-40f}},
                        {{-1e4f, 3e4f, 7}, {-1e4f, 3.1e4f, 7}}};
  for (const Aabb& box : boxes) {
    const Vec3d pad = cell_padding(box);
    const double pads[3] = {pad.x, pad.y, pad.z};
    const Aabb larger = padded(box, pad);
    for (int a = 0; a < 3; ++a) {
      EXPECT_LT(larger.lo[a], box.lo[a]);
      EXPECT_GT(larger.hi[a], box.hi[a]);
      EXPECT_LE(larger.lo[a], box.lo[a] - pads[a]);
      EXPECT_GE(larger.hi[a], box.hi[a] + pads[a]);
    }
  }
}

}  // namespace
}  // namespace accel
