#include "libaccel/geometry/mesh_facts.h"

#include <gtest/gtest.h>

#include "libaccel/core/float_bounds.h"
#include "libaccel/core/ray.h"
#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

TEST(IsZeroArea, PointsAndLines) {
  const Vec3 p{0.1f, 0.2f, 0.3f}, q{1e10f, -3.7f, 1e-10f}, r{5, 6, 7};
  EXPECT_TRUE(is_zero_area({p, p, p}));
  EXPECT_TRUE(is_zero_area({p, p, q}));
  EXPECT_TRUE(is_zero_area({p, q, p}));
  EXPECT_TRUE(is_zero_area({q, p, p}));
  EXPECT_TRUE(is_zero_area({{0, 0, 0}, {1, 2, 3}, {3, 6, 9}}));
  EXPECT_TRUE(is_zero_area({{1, 1, 1}, {1, 5, 1}, {1, 3, 1}}));
  EXPECT_FALSE(is_zero_area({p, q, r}));
}

TEST(IsZeroArea, OneUlpMakesATriangle) {
  const float x = 0.7f;
  EXPECT_TRUE(is_zero_area({{0, 0, 0}, {x, x, x}, {2 * x, 2 * x, 2 * x}}));
  EXPECT_FALSE(is_zero_area({{0, 0, 0}, {x, x, x}, {2 * x, 2 * x, next_up(2 * x)}}));
  EXPECT_FALSE(is_zero_area({{1, 1, 0}, {2, 2, 0}, {3, next_down(3.0f), 0}}));
}

// Both products of the normal's last component round to 2^68 + 2^45 - 2^16: a test in doubles alone would drop the triangle.
TEST(IsZeroArea, ProductsThatOnlyRoundToTheSameDouble) {
  const float a = 0x1p34f, b = next_up(a), r = 0x1p-18f;
  EXPECT_EQ((static_cast<double>(a) - r) * b, a * (static_cast<double>(b) - r));
  EXPECT_FALSE(is_zero_area({{r, 0, 0}, {a, a, 0}, {b, b, 0}}));
}

TEST(IsZeroArea, WithoutProofTheAnswerIsNo) {
  // Collinear, but 2^-60 + 2^60 has no double.
  EXPECT_FALSE(is_zero_area({{-0x1p-60f, -0x1p-60f, 0}, {0x1p60f, 0x1p60f, 0}, {1, 1, 0}}));
}

TEST(IsZeroArea, DenormalTriangles) {
  const float d = std::numeric_limits<float>::denorm_min();
  EXPECT_FALSE(is_zero_area({{0, 0, 0}, {d, 0, 0}, {0, d, 0}}));
  EXPECT_TRUE(is_zero_area({{0, 0, 0}, {d, d, 0}, {2 * d, 2 * d, 0}}));
}

TEST(IsInRange, LimitsAndNaN) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(is_in_range({{kMaxCoordinate, 0, 0}, {0, -kMaxCoordinate, 0}, {}}));
  EXPECT_FALSE(is_in_range({{}, {next_up(kMaxCoordinate), 0, 0}, {}}));
  EXPECT_FALSE(is_in_range({{}, {}, {0, 0, nan}}));
  EXPECT_FALSE(is_in_range({{}, {0, -inf, 0}, {}}));
}

TEST(MeshFacts, Counts) {
  const MeshFacts facts = mesh_facts(test::soup_with_rejects(100));
  EXPECT_EQ(facts.triangles, 100u);
  EXPECT_EQ(facts.zero_area, 10u);
  EXPECT_EQ(facts.out_of_range, 10u);
  EXPECT_FALSE(facts.bounds.empty());
  EXPECT_LT(facts.bounds.hi.x, 2.0f);
  EXPECT_TRUE(mesh_facts(TriangleMesh{}).bounds.empty());
}

}  // namespace
}  // namespace accel
