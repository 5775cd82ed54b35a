#include "libaccel/core/hit.h"

#include <gtest/gtest.h>

#include <cstddef>

namespace accel {
namespace {

TEST(Hit, StartsAsAMiss) {
  const Hit hit;
  EXPECT_FALSE(hit.valid());
  EXPECT_EQ(hit.t, std::numeric_limits<float>::infinity());
  EXPECT_EQ(hit.u, 0.0f);
  EXPECT_EQ(hit.v, 0.0f);
}

TEST(Hit, TriangleZeroIsAHit) { EXPECT_TRUE((Hit{.t = 0, .prim_id = 0}).valid()); }

// The layout that .npy files and device buffers rely on.
TEST(Hit, Layout) {
  EXPECT_EQ(offsetof(Hit, t), 0u);
  EXPECT_EQ(offsetof(Hit, u), 4u);
  EXPECT_EQ(offsetof(Hit, v), 8u);
  EXPECT_EQ(offsetof(Hit, prim_id), 12u);
}

}  // namespace
}  // namespace accel
