#include "libaccel/packet/pixel_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/rays/ray_sets.h"

namespace accel {
namespace {

std::vector<Ray> pixels(std::uint32_t width, std::uint32_t height, PixelOrder order = PixelOrder::rows, std::uint32_t spp = 1) {
  const float vfov = 0.125f * static_cast<float>(height);  // pixels are as large as those of usual pictures
  const Camera camera = Camera::make({{1, 2, 3}, {0, 0, -1}, {0, 1, 0}, vfov, ""}, width, height).value();
  const RaySet set = primary_rays(camera, spp, 1, order).value();
  return {set.rays.begin(), set.rays.end()};
}

PixelRows rows_of(const std::vector<Ray>& rays) { return find_rows(rays, 0.1f); }

TEST(PixelRows, AreThoseOfThePicture) {
  for (const std::uint32_t width : {128u, 200u, 333u, 640u, 1366u}) {
    const std::vector<Ray> rays = pixels(width, 24);
    EXPECT_EQ(rows_of(rays).length, width);
    EXPECT_EQ(rows_of(rays).first, 0u);
    // From the middle of a row on, as blocks of a batch begin.
    for (const std::uint32_t x : {1u, 64u, width - 1}) {
      const PixelRows rows = rows_of({rays.begin() + x, rays.end()});
      EXPECT_EQ(rows.length, width);
      EXPECT_EQ(rows.first, width - x);
    }
  }
}

TEST(PixelRows, MayLackRays) {
  const std::vector<Ray> whole = pixels(640, 40);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < whole.size(); ++i)
    if (i % 1000 != 7) rays.push_back(whole[i]);
  const PixelRows rows = rows_of(rays);
  EXPECT_GE(rows.length, 638u);
  EXPECT_LE(rows.length, 640u);
}

TEST(PixelRows, MayHaveRaysThatNothingCanTrace) {
  std::vector<Ray> rays = pixels(640, 40);
  for (std::size_t i = 5; i < rays.size(); i += 501) rays[i].dir = {};
  for (std::size_t i = 9; i < rays.size(); i += 1001) rays[i].org.x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(rows_of(rays).length, 640u);
}

// Rays from a floor to a light: origins tell of rows there, and directions hardly.
TEST(PixelRows, AreFoundAmongShadowRays) {
  std::vector<Ray> rays = pixels(640, 40);
  for (Ray& ray : rays) {
    const Vec3 at = ray.org + ray.dir * std::fabs(3 / ray.dir.z);
    ray = {.org = at, .dir = Vec3{2, 9, 1} - at, .t_max = 1};
  }
  EXPECT_EQ(rows_of(rays).length, 640u);
}

TEST(PixelRows, AreNotFoundWhereThereAreNone) {
  EXPECT_EQ(rows_of({}).length, 0u);
  EXPECT_EQ(rows_of(std::vector<Ray>(5000, Ray{.org = {}, .dir = {0, 0, 1}})).length, 0u) << "all rays are one";
  EXPECT_EQ(rows_of(pixels(640, 4)).length, 0u) << "too few rows";
  EXPECT_EQ(rows_of(pixels(64, 64)).length, 0u) << "rows are short";
  EXPECT_EQ(rows_of(pixels(256, 256, PixelOrder::z_curve)).length, 0u);
  EXPECT_EQ(rows_of(pixels(64, 64, PixelOrder::rows, 16)).length, 0u) << "samples of a pixel are no row";
  CounterRng rng(1, 0);
  std::vector<Ray> rays(20'000);
  for (Ray& ray : rays) ray = {.org = {}, .dir = {rng.next_float(-1, 1), rng.next_float(-1, 1), rng.next_float(-1, 1)}};
  EXPECT_EQ(rows_of(rays).length, 0u);
}

}  // namespace
}  // namespace accel
