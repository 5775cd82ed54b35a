#include "libaccel/rays/default_light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libaccel/core/vec3d.h"

namespace accel {
namespace {

const Aabb kRoom{{-4, 0, -3}, {4, 3, 3}};

TEST(DefaultLight, HangsBelowTheCeilingOfARoom) {
  const LightDescription light = default_light(kRoom, {{1, 1.7f, 2}, {0, 1, 0}, {0, 1, 0}, 45, ""});
  EXPECT_TRUE(kRoom.contains(Aabb{light.center, light.center}));
  EXPECT_NEAR(light.center.y, 2.7, 1e-6);
  EXPECT_EQ(light.half_u.y, 0);
  EXPECT_EQ(light.half_v.y, 0);
  EXPECT_GT(length(cross(Vec3d(light.half_u), Vec3d(light.half_v))), 0);
}

TEST(DefaultLight, FloatsAboveAnObject) {
  const LightDescription light = default_light(kRoom, {{0, 2, 30}, {0, 1, 0}, {0, 1, 0}, 45, ""});
  EXPECT_GT(light.center.y, kRoom.hi.y);
  EXPECT_EQ(light.center.x, 0);
}

TEST(DefaultLight, FollowsTheCamerasUp) {
  EXPECT_GT(default_light(kRoom, {{0, -90, 0}, {0, 0, 0}, {0, 0.1f, 1}, 45, ""}).center.z, kRoom.hi.z);
  EXPECT_LT(default_light(kRoom, {{0, 0, 90}, {0, 0, 0}, {0, -1, 0}, 45, ""}).center.y, kRoom.lo.y);
}

TEST(DefaultLight, CopesWithAnEmptyBox) {
  const LightDescription light = default_light(Aabb{}, {});
  EXPECT_TRUE(std::isfinite(light.center.x) && std::isfinite(light.center.y) && std::isfinite(light.half_u.x + light.half_v.x));
}

}  // namespace
}  // namespace accel
