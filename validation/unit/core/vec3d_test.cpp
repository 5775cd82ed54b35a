#include "libaccel/core/vec3d.h"

#include <gtest/gtest.h>

#include "libaccel/core/counter_rng.h"

namespace accel {
namespace {

TEST(Vec3d, NormalizesWithoutOverflowOrUnderflow) {
  for (const float scale : {1e-38f, 1.0f, 1e38f}) {
    const Vec3d n = normalized(Vec3d(Vec3{scale, -2 * scale, 2 * scale}));
    EXPECT_NEAR(n.x, 1 / 3.0, 1e-7);
    EXPECT_NEAR(length(n), 1, 1e-15);
  }
}

TEST(Vec3d, BasisIsRightHandedAndOrthonormal) {
  CounterRng rng(1, 0);
  for (int i = 0; i < 1000; ++i) {
    // The last ones lie near the pole where naive constructions break down.
    const double spread = i < 900 ? 1.0 : 1e-9;
    const Vec3d n =
        normalized({spread * (rng.next_double() - 0.5), spread * (rng.next_double() - 0.5), i % 2 == 0 ? 0.5 : -0.5});
    Vec3d t, b;
    make_basis(n, t, b);
    EXPECT_NEAR(length(t), 1, 1e-12);
    EXPECT_NEAR(dot(t, n), 0, 1e-12);
    EXPECT_NEAR(length(cross(t, b) - n), 0, 1e-12);
  }
}

}  // namespace
}  // namespace accel
