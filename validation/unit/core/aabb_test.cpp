#include "libaccel/core/aabb.h"

#include <gtest/gtest.h>

#include <cmath>

#include "validation/stress/hostile_floats.h"

namespace accel {
namespace {

const Aabb kUnit{{0, 0, 0}, {1, 1, 1}};

TEST(Aabb, StartsEmpty) {
  const Aabb box;
  EXPECT_TRUE(box.empty());
  EXPECT_EQ(box.half_area(), 0.0f);
}

TEST(Aabb, EmptyIsTheIdentityOfExtend) {
  Aabb box;
  box.extend(kUnit);
  EXPECT_EQ(box.lo, kUnit.lo);
  EXPECT_EQ(box.hi, kUnit.hi);
  box.extend(Aabb{});
  EXPECT_EQ(box.lo, kUnit.lo);
  EXPECT_EQ(box.hi, kUnit.hi);
}

TEST(Aabb, APointIsNotEmpty) {
  Aabb box;
  box.extend(Vec3{1, 2, 3});
  EXPECT_FALSE(box.empty());
  EXPECT_EQ(box.half_area(), 0.0f);
  EXPECT_EQ(box.extent(), (Vec3{0, 0, 0}));
}

TEST(Aabb, NaNCoordinatesDoNotExtend) {
  Aabb box = kUnit;
  const float nan = std::nanf("");
  box.extend(Vec3{nan, nan, nan});
  EXPECT_EQ(box.lo, kUnit.lo);
  EXPECT_EQ(box.hi, kUnit.hi);
}

TEST(Aabb, ContainsIsClosed) {
  EXPECT_TRUE(kUnit.contains(kUnit));
  EXPECT_TRUE(kUnit.contains(Aabb{{0.5f, 0, 0}, {0.5f, 1, 1}}));
  EXPECT_FALSE(kUnit.contains(Aabb{{-0.1f, 0, 0}, {1, 1, 1}}));
  EXPECT_FALSE(kUnit.contains(Aabb{{0, 0, 0}, {1, 1, 1.1f}}));
}

TEST(Aabb, HalfAreaOfABrick) { EXPECT_EQ((Aabb{{0, 0, 0}, {1, 2, 3}}).half_area(), 1 * 2 + 2 * 3 + 3 * 1); }

TEST(Aabb, CenterDoesNotOverflow) {
  const float large = 3e38f;
  EXPECT_EQ((Aabb{{large, -large, 0}, {large, large, 1}}).center(), (Vec3{large, 0, 0.5f}));
}

TEST(Aabb, IntersectionIsWhatLiesInBoth) {
  const Aabb both = intersection(kUnit, {{0.5f, -1, 1}, {2, 2, 2}});
  EXPECT_EQ(both.lo, (Vec3{0.5f, 0, 1}));
  EXPECT_EQ(both.hi, (Vec3{1, 1, 1}));
  EXPECT_FALSE(both.empty());
  EXPECT_TRUE(intersection(kUnit, {{2, 0, 0}, {3, 1, 1}}).empty());
}

TEST(Aabb, ExtendedBoxesContainTheirPoints) {
  for (std::uint64_t i = 0; i < 1000; ++i) {
    CounterRng rng(1, i);
    Aabb box;
    Vec3 points[8];
    for (Vec3& p : points) {
      for (int a = 0; a < 3; ++a) p[a] = validation::random_over_exponents(rng, -140, 100);
      box.extend(p);
    }
    for (const Vec3& p : points) EXPECT_TRUE(box.contains(Aabb{p, p}));
  }
}

}  // namespace
}  // namespace accel
