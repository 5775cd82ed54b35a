#include "libaccel/packet/ray_hash.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "libaccel/core/counter_rng.h"

namespace accel {
namespace {

const Aabb kBox{{-1, -2, -3}, {4, 3, 2}};

Ray random_ray(CounterRng& rng) {
  const auto in = [&](float lo, float hi) {
    return lo + (hi - lo) * static_cast<float>(rng.next_below(1u << 20)) / 1048576.0f;
  };
  return {.org = {in(-1, 4), in(-2, 3), in(-3, 2)}, .dir = {in(-1, 1), in(-1, 1), in(-1, 1)}};
}

// Rays with equal values start in the same cell, and their directions have the same dominant axis, sign and cell of the face.
TEST(RayHash, EqualValuesAreCoherent) {
  const float fraction = 0.2f;
  const auto hash = RayHash<std::uint64_t>::make(kBox, fraction);
  const float cell = fraction * std::sqrt(75.0f);
  CounterRng rng(1, 0);
  int equal = 0;
  for (int i = 0; i < 200000; ++i) {
    const Ray a = random_ray(rng);
    Ray b = random_ray(rng);
    b.org = a.org + (b.org - a.org) * 0.02f, b.dir = a.dir + (b.dir - a.dir) * 0.02f;
    if (hash(a) != hash(b)) continue;
    ++equal;
    const int axis = largest_axis(a.dir);
    ASSERT_EQ(axis, largest_axis(b.dir));
    ASSERT_EQ(a.dir[axis] < 0, b.dir[axis] < 0);
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(std::fabs(a.org[k] - b.org[k]), cell * 1.0001f);
      EXPECT_LE(std::fabs(a.dir[k] / std::fabs(a.dir[axis]) - b.dir[k] / std::fabs(b.dir[axis])), 2.0001f / 64);
    }
  }
  EXPECT_GT(equal, 1000);
}

TEST(RayHash, NarrowValuesAliasFarCellsOnly) {
  const auto hash = RayHash<std::uint32_t>::make(kBox, 0.0005f);
  const float cell = 0.0005f * std::sqrt(75.0f);
  const Ray ray{.org = {0.5f * cell - 1, -2, -3}, .dir = {0, 0, 1}};
  for (int cells = 1; cells < 300; ++cells) {
    Ray other = ray;
    other.org.x += static_cast<float>(cells) * cell;
    EXPECT_EQ(hash(other) == hash(ray), cells == 256) << cells;
    EXPECT_NE(RayHash<std::uint64_t>::make(kBox, 0.0005f)(other), RayHash<std::uint64_t>::make(kBox, 0.0005f)(ray));
  }
}

TEST(RayHash, EveryFaceHasItsOwnValues) {
  const auto wide = RayHash<std::uint64_t>::make(kBox, 0.01f);
  const auto narrow = RayHash<std::uint32_t>::make(kBox, 0.01f);
  std::set<std::uint64_t> values;
  for (const Vec3 d : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}, Vec3{0, 0, 1}, Vec3{0, 0, -1}}) {
    values.insert(wide({.org = {0, 0, 0}, .dir = d}));
    values.insert(std::uint64_t{1} << 63 | narrow({.org = {0, 0, 0}, .dir = d}));
  }
  EXPECT_EQ(values.size(), 12u);
}

TEST(RayHash, OriginsOnlyIgnoresDirections) {
  const auto hash = RayHash<std::uint64_t>::make(kBox, 0.01f, true);
  EXPECT_EQ(hash({.org = {1, 1, 1}, .dir = {1, 0, 0}}), hash({.org = {1, 1, 1}, .dir = {0, -1, 0}}));
  EXPECT_NE(hash({.org = {1, 1, 1}, .dir = {1, 0, 0}}), hash({.org = {2, 1, 1}, .dir = {1, 0, 0}}));
}

TEST(RayHash, IsDefinedForEverything) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const Vec3 odd[] = {{nan, nan, nan}, {inf, -inf, 0}, {3e38f, -3e38f, 1e-40f}, {0, 0, 0}, {-0.0f, 1, 0}};
  for (const Aabb& box : {kBox, Aabb{}, Aabb{{1, 1, 1}, {1, 1, 1}}, Aabb{{-3e38f, -3e38f, -3e38f}, {3e38f, 3e38f, 3e38f}}})
    for (const Vec3 org : odd)
      for (const Vec3 dir : odd)
        for (const float fraction : {0.004f, 1e-30f, 1.0f}) {
          const Ray ray{.org = org, .dir = dir};
          EXPECT_LT(RayHash<std::uint64_t>::make(box, fraction)(ray), std::uint64_t{1} << 63);
          EXPECT_LT(RayHash<std::uint32_t>::make(box, fraction)(ray), 1u << 31);
        }
}

}  // namespace
}  // namespace accel
