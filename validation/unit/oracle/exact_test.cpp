#include "validation/oracle/exact.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "libaccel/core/float_bounds.h"
#include "validation/unit/compare/test_scenes.h"
#include "validation/unit/special_floats.h"

namespace accel::validation {
namespace {

using test::make_mesh;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

Ray ray_to(Vec3 org, Vec3 dir, float t_min = 0, float t_max = kInfinity) { return {org, t_min, dir, t_max}; }

TEST(ExactOracle, HitsInsideAndMissesOutside) {
  const ExactOracle oracle(test::square());
  const ExactHit hit = oracle.closest(ray_to({0.75f, 0.25f, 3}, {0, 0, -2}));
  EXPECT_EQ(hit.t, 1.5);
  EXPECT_THAT(hit.prims, ElementsAre(0));
  EXPECT_FALSE(oracle.closest(ray_to({1.5f, 0.25f, 3}, {0, 0, -2})).valid());
  EXPECT_FALSE(oracle.closest(ray_to({0.75f, 0.25f, 3}, {0, 0, 2})).valid());
}

TEST(ExactOracle, EdgesAndVerticesBelongToTheTriangle) {
  const ExactOracle oracle(test::square());
  EXPECT_THAT(oracle.closest(ray_to({0.5f, 0.5f, 1}, {0, 0, -1})).prims, ElementsAre(0, 1));
  EXPECT_THAT(oracle.closest(ray_to({0, 0, 1}, {0, 0, -1})).prims, ElementsAre(0, 1));
  EXPECT_THAT(oracle.closest(ray_to({1, 0, 1}, {0, 0, -1})).prims, ElementsAre(0));
  EXPECT_THAT(oracle.closest(ray_to({0.5f, 1, 1}, {0, 0, -1})).prims, ElementsAre(1));
  EXPECT_THAT(oracle.closest(ray_to({0.5f, next_up(1), 1}, {0, 0, -1})).prims, IsEmpty());
}

// A ray that passes the diagonal at a distance of about 2^-100, far below what double can see beside the coordinates.
TEST(ExactOracle, TellsWhatDoubleCannot) {
  const ExactOracle oracle(test::square());
  const auto hit_with_offset = [&](float offset) { return oracle.closest(ray_to({0.5f, 0.5f, 1}, {offset, 0, -1})).prims; };
  EXPECT_THAT(hit_with_offset(0x1p-100f), ElementsAre(0));
  EXPECT_THAT(hit_with_offset(-0x1p-100f), ElementsAre(1));
  EXPECT_THAT(hit_with_offset(std::numeric_limits<float>::denorm_min()), ElementsAre(0));
}

TEST(ExactOracle, NamesEveryTriangleAtTheNearestT) {
  // Two parallel copies of a triangle at z = 0, one at z = 1, one that crosses z = 0 in the ray's path.
  const TriangleMesh mesh =
      make_mesh({{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}, {-1, -1, 1}, {3, -1, 1}, {-1, 3, 1}, {-2, 0, -2}, {2, 0, 2}, {0, 1, 0}},
                {{3, 4, 5}, {0, 1, 2}, {2, 1, 0}, {6, 7, 8}});
  const ExactOracle oracle(mesh);
  EXPECT_THAT(oracle.closest(ray_to({0, 0.5f, -5}, {0, 0, 1})).prims, ElementsAre(1, 2, 3));
  EXPECT_THAT(oracle.closest(ray_to({0, 0.5f, 5}, {0, 0, -1})).prims, ElementsAre(0));
}

TEST(ExactOracle, TheIntervalIsClosed) {
  const ExactOracle oracle(test::square());
  const Vec3 org{0.75f, 0.25f, 3}, dir{0, 0, -2};
  EXPECT_TRUE(oracle.closest(ray_to(org, dir, 1.5f)).valid());
  EXPECT_FALSE(oracle.closest(ray_to(org, dir, next_up(1.5f))).valid());
  EXPECT_TRUE(oracle.closest(ray_to(org, dir, 0, 1.5f)).valid());
  EXPECT_FALSE(oracle.closest(ray_to(org, dir, 0, next_down(1.5f))).valid());
  EXPECT_TRUE(oracle.closest(ray_to(org, dir, 1.5f, 1.5f)).valid());

  const Vec3 on_surface{0.75f, 0.25f, 0};
  EXPECT_EQ(oracle.closest(ray_to(on_surface, dir, -1)).t, 0);
  EXPECT_TRUE(oracle.any(ray_to(on_surface, dir, 0, 0)));
  EXPECT_FALSE(oracle.any(ray_to({0.75f, 0.25f, -1}, dir, -10, 10)));
}

// t = 1/3 is no float: the interval's end must be compared with the exact quotient.
TEST(ExactOracle, TheIntervalEndsAtExactT) {
  const ExactOracle oracle(test::square());
  const Ray ray = ray_to({0.75f, 0.25f, 1}, {0, 0, -3});
  const float third = 1.0f / 3.0f, below = third > 1.0 / 3.0 ? next_down(third) : third, above = next_up(below);
  const auto hits = [&](float t_min, float t_max) { return oracle.any(ray_to(ray.org, ray.dir, t_min, t_max)); };
  EXPECT_TRUE(hits(below, kInfinity));
  EXPECT_FALSE(hits(above, kInfinity));
  EXPECT_TRUE(hits(0, above));
  EXPECT_FALSE(hits(0, below));
  EXPECT_DOUBLE_EQ(oracle.closest(ray).t, 1.0 / 3.0);
}

TEST(ExactOracle, RaysInThePlaneAndTrianglesWithoutAreaMiss) {
  const ExactOracle oracle(test::square());
  EXPECT_FALSE(oracle.any(ray_to({-1, 0.5f, 0}, {1, 0, 0})));
  EXPECT_FALSE(oracle.any(ray_to({-1, -1, 0}, {1, 1, 0})));

  // Collinear vertices whose double-precision normal is not zero, and a point.
  const TriangleMesh degenerate =
      make_mesh({{0.1f, 0.1f, 0}, {0.2f, 0.2f, 0}, {0.7f, 0.7f, 0}, {1, 1, 0}}, {{0, 1, 2}, {3, 3, 3}});
  const ExactOracle thin(degenerate);
  EXPECT_FALSE(thin.any(ray_to({0.2f, 0.2f, 1}, {0, 0, -1})));
  EXPECT_FALSE(thin.any(ray_to({1, 1, 1}, {0, 0, -1})));
  EXPECT_FALSE(thin.can_be_hit(0));
  EXPECT_FALSE(thin.can_be_hit(1));
  EXPECT_TRUE(oracle.can_be_hit(0));
}

TEST(ExactOracle, BadRaysAndVerticesMiss) {
  const ExactOracle oracle(test::square());
  const Vec3 org{0.75f, 0.25f, 1}, dir{0, 0, -1};
  EXPECT_TRUE(oracle.any(ray_to(org, dir)));
  for (const Ray& bad : {ray_to({kNaN, 0, 0}, dir), ray_to(org, {0, 0, 0}), ray_to(org, {0, 0, -kInfinity}),
                         ray_to(org, dir, 2, 1), ray_to(org, dir, kNaN), ray_to(org, dir, 0, kNaN), ray_to(org, dir, -2, -1)}) {
    EXPECT_FALSE(oracle.closest(bad).valid());
    EXPECT_FALSE(oracle.any(bad));
    EXPECT_THAT(oracle.near(bad, 1, kInfinity), IsEmpty());
  }
  const ExactOracle broken(
      make_mesh({{0, 0, 0}, {2, 0, 0}, {0, kNaN, 0}, {0, 2, 0}, {0, 1e19f, 0}}, {{0, 1, 2}, {0, 1, 4}, {0, 1, 3}}));
  EXPECT_THAT(broken.closest(ray_to({0.5f, 0.5f, 1}, dir)).prims, ElementsAre(2));
  EXPECT_FALSE(broken.point(ray_to({0.5f, 0.5f, 1}, dir), 1));
  EXPECT_FALSE(ExactOracle(TriangleMesh{}).any(ray_to(org, dir)));
}

TEST(ExactOracle, PointHasTheBarycentricCoordinatesOfHit) {
  const ExactOracle oracle(make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 8, 0}}, {{0, 1, 2}}));
  const auto point = oracle.point(ray_to({1, 4, 3}, {0, 0, -1}), 0);
  ASSERT_TRUE(point);
  EXPECT_EQ(point->t, 3);
  EXPECT_EQ(point->u, 0.25);
  EXPECT_EQ(point->v, 0.5);
}

// The largest and smallest numbers: nothing overflows the integers, nothing underflows.
TEST(ExactOracle, ExtremeCoordinates) {
  const float big = kMaxCoordinate, small = std::numeric_limits<float>::denorm_min();
  const ExactOracle large(
      make_mesh({{-big, -big, big}, {big, -big, big}, {big, big, big}, {-big, big, big}}, {{0, 1, 2}, {0, 2, 3}}));
  EXPECT_THAT(large.closest(ray_to({0, 0, -big}, {0, 0, big})).prims, ElementsAre(0, 1));
  EXPECT_EQ(large.closest(ray_to({0, 0, -big}, {0, 0, big})).t, 2);
  EXPECT_THAT(large.closest(ray_to({0, 0, -big}, {0, small, big})).prims, ElementsAre(1));

  const ExactOracle tiny(make_mesh({{0, 0, small}, {2 * small, 0, small}, {0, 2 * small, small}}, {{0, 1, 2}}));
  EXPECT_THAT(tiny.closest(ray_to({small, small, 0}, {0, 0, small})).prims, ElementsAre(0));
  EXPECT_EQ(tiny.closest(ray_to({small, small, 0}, {0, 0, small})).t, 1);
  EXPECT_FALSE(tiny.any(ray_to({small, 2 * small, 0}, {0, 0, small})));
  // Its t would be 2^149 * 2^-60: too large for a Hit.
  EXPECT_FALSE(large.any(ray_to({0, 0, -big}, {0, 0, small})));
}

TEST(ExactOracle, ScalingByPowersOfTwoChangesNothing) {
  const TriangleMesh mesh = test::soup(200, 3);
  const std::vector<Ray> rays = test::edge_rays(mesh, {0, 0, 0}, 2, 500, 4);
  const ExactOracle oracle(mesh);
  for (const float scale : {0x1p-40f, 0x1p40f}) {
    const ExactOracle scaled(test::transformed(mesh, scale, {}));
    for (const Ray& ray : rays) {
      const ExactHit a = oracle.closest(ray), b = scaled.closest(ray_to(ray.org * scale, ray.dir * scale));
      EXPECT_EQ(a.prims, b.prims);
      EXPECT_EQ(a.t, b.t);
    }
  }
}

TEST(ExactOracle, TreeFindsWhatTheLoopOverAllFinds) {
  for (const float offset : {0.0f, 1.0f, 1000.0f}) {
    const TriangleMesh mesh = test::transformed(test::soup(400, 5), 1, {offset, -offset, offset});
    const ExactOracle tree(mesh), all(mesh, ExactOracle::Search::all);
    std::vector<Ray> rays = test::edge_rays(mesh, {offset, -offset, offset}, 2, 1000, 6);
    for (std::size_t i = 0; i < rays.size(); i += 5) rays[i].dir[static_cast<int>(i / 5 % 3)] = i % 2 ? 0.0f : -0.0f;
    for (std::size_t i = 0; i < rays.size(); i += 7) rays[i].t_min = 0.5f, rays[i].t_max = 1.0f;
    for (const Ray& ray : rays) {
      const ExactHit a = tree.closest(ray), b = all.closest(ray);
      EXPECT_EQ(a.prims, b.prims);
      EXPECT_EQ(a.t, b.t);
      EXPECT_EQ(tree.any(ray), b.valid());
    }
  }
}

TEST(ExactOracle, TiesAtVerticesOfClosedMeshes) {
  const TriangleMesh mesh = test::sphere(2);
  const ExactOracle oracle(mesh);
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
    // A ray along an axis meets the vertex exactly; six triangles (four at the octahedron's corners) share it.
    const Vec3 v = mesh.vertices[i];
    const ExactHit hit = oracle.closest(ray_to({v.x, v.y, v.z > 0 ? 2.0f : -2.0f}, {0, 0, v.z > 0 ? -1.0f : 1.0f}));
    if (v.z == 0) continue;  // on the silhouette
    EXPECT_EQ(hit.prims.size(), i < 6 ? 4 : 6);
  }
}

// Deep trees: all centroids in one place, and geometric series of sizes.
TEST(ExactOracle, TreesOfAwkwardMeshes) {
  std::vector<Vec3> v;
  std::vector<IndexTriple> t;
  for (std::uint32_t i = 0; i < 300; ++i) {
    const float s = i < 150 ? 1.0f : std::exp2(-0.5f * static_cast<float>(i - 150));
    v.insert(v.end(), {{-s, -s, 0}, {s, -s, 0}, {0, s, 0}});
    t.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const ExactOracle oracle(make_mesh(std::move(v), std::move(t)));
  EXPECT_EQ(oracle.closest(ray_to({0, 0, 1}, {0, 0, -1})).prims.size(), 300);
}

TEST(ExactOracle, NearFindsTrianglesBesideTheRay) {
  const ExactOracle oracle(test::square());
  const Ray ray = ray_to({1 + 0x1p-22f, 0.5f, 1}, {0, 0, -1});
  EXPECT_FALSE(oracle.any(ray));
  EXPECT_THAT(oracle.near(ray, 0x1p-18, kInfinity), ElementsAre(0, 1));
  EXPECT_THAT(oracle.near(ray, 0x1p-24, kInfinity), IsEmpty());
}

}  // namespace
}  // namespace accel::validation
