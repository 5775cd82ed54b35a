#include "libaccel/rays/sampling.h"

#include <gtest/gtest.h>

#include <set>

namespace accel {
namespace {

TEST(PointInCell, CellsTileTheSquareInEqualShares) {
  // Whatever the number of cells, one random point in each lands everywhere with the same density: half of all points in each
  // half of the square, in x and in y, within five standard errors of independent points (stratified ones spread less).
  for (const std::uint32_t count : {1u, 2u, 3u, 5u, 7u, 12u, 16u, 17u, 100u}) {
    int left = 0, upper = 0;
    constexpr int kPoints = 20000;
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      CounterRng rng(count, i);
      const UnitPoint p = point_in_cell(i % count, count, rng);
      ASSERT_TRUE(p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1);
      left += p.x < 0.5, upper += p.y < 0.5;
    }
    const double tolerance = 5 * std::sqrt(0.25 * kPoints) + kPoints % count;
    EXPECT_NEAR(left, kPoints / 2, tolerance) << count;
    EXPECT_NEAR(upper, kPoints / 2, tolerance) << count;
  }
}

TEST(PointInCell, SixteenCellsAreFourByFour) {
  std::set<int> cells;
  for (std::uint32_t i = 0; i < 16; ++i) {
    CounterRng rng(1, i);
    const UnitPoint p = point_in_cell(i, 16, rng);
    cells.insert(static_cast<int>(p.y * 4) * 4 + static_cast<int>(p.x * 4));
  }
  EXPECT_EQ(cells.size(), 16u);
}

TEST(CosineDirection, HasTheRightMoments) {
  // With density cos / pi the mean of the cosine is 2/3 and that of its square 1/2; the tangential mean is 0.
  const Vec3d n = normalized({1, -2, 0.5});
  Vec3d sum;
  double cosines = 0, squares = 0;
  constexpr int kCount = 100000;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    CounterRng rng(1, i);
    const Vec3d d = cosine_direction(n, rng);
    const double cosine = dot(d, n);
    ASSERT_NEAR(length(d), 1, 1e-12);
    ASSERT_GE(cosine, 0x1p-13);
    sum = sum + d, cosines += cosine, squares += cosine * cosine;
  }
  const double tolerance = 5 / std::sqrt(double{kCount});
  EXPECT_NEAR(cosines / kCount, 2 / 3.0, tolerance * std::sqrt(1 / 18.0));
  EXPECT_NEAR(squares / kCount, 0.5, tolerance * std::sqrt(1 / 12.0));
  EXPECT_LE(length(sum * (1.0 / kCount) - n * (cosines / kCount)), tolerance);
}

TEST(SphereDirection, HasNoPreference) {
  Vec3d sum, squares;
  constexpr int kCount = 100000;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    CounterRng rng(2, i);
    const Vec3d d = sphere_direction(rng);
    ASSERT_NEAR(length(d), 1, 1e-12);
    sum = sum + d, squares = squares + Vec3d{d.x * d.x, d.y * d.y, d.z * d.z};
  }
  EXPECT_LE(length(sum) / kCount, 5 / std::sqrt(double{kCount}));
  for (const double square : {squares.x, squares.y, squares.z})
    EXPECT_NEAR(square / kCount, 1 / 3.0, 5 * 0.3 / std::sqrt(double{kCount}));
}

}  // namespace
}  // namespace accel
