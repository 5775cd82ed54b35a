#include "validation/compare/must_hit.h"

#include <gtest/gtest.h>

#include "validation/unit/compare/test_scenes.h"

namespace accel::validation {
namespace {

// Whether a ray along -z through (x, y) must hit the given triangles of a mesh.
bool must_hit(const TriangleMesh& mesh, float x, float y, const std::vector<std::uint32_t>& prims) {
  const RayFrame frame(Ray{{x, y, 2}, 0, {0, 0, -1}});
  MustHit evidence;
  for (const std::uint32_t prim : prims) {
    const TriangleBounds bounds(frame, mesh.triangle(prim));
    if (bounds.possible) evidence.add(mesh.triangle(prim), bounds);
  }
  return evidence.decide();
}

TEST(MustHit, NothingMustNotBeHit) { EXPECT_FALSE(MustHit().decide()); }

TEST(MustHit, InsideOneTriangle) {
  EXPECT_TRUE(must_hit(test::square(), 0.75f, 0.25f, {0, 1}));
  EXPECT_FALSE(must_hit(test::square(), 0.75f, 0.25f, {1}));
}

TEST(MustHit, BothSidesOfAnEdgeOrNone) {
  EXPECT_TRUE(must_hit(test::square(), 0.5f, 0.5f, {0, 1}));
  EXPECT_FALSE(must_hit(test::square(), 0.5f, 0.5f, {0}));
  EXPECT_FALSE(must_hit(test::square(), 0.5f, 0.5f, {1}));
  EXPECT_TRUE(must_hit(test::square(), 0.5f, 0.5f, {0, 1, 0, 1})) << "duplicates take nothing away";
}

// A fan of n triangles around the origin; without any one of them the vertex is on the boundary.
TEST(MustHit, AFanMustBeClosed) {
  for (const std::uint32_t n : {3u, 4u, 7u, 100u}) {
    std::vector<Vec3> v{{0, 0, 0}};
    std::vector<IndexTriple> t;
    std::vector<std::uint32_t> all;
    for (std::uint32_t i = 0; i < n; ++i) {
      const double angle = 6.283185307179586 * i / n + 0.1;
      v.push_back({static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0});
      t.push_back({0, 1 + i, 1 + (i + 1) % n});
      all.push_back(i);
    }
    const TriangleMesh mesh = test::make_mesh(v, t);
    EXPECT_TRUE(must_hit(mesh, 0, 0, all)) << n;
    for (std::uint32_t gap = 0; gap < std::min(n, 7u); ++gap) {
      std::vector<std::uint32_t> some = all;
      some.erase(some.begin() + gap);
      EXPECT_FALSE(must_hit(mesh, 0, 0, some)) << n << " without " << gap;
    }
  }
}

// Two closed layers over the same vertex: each by itself must be hit, whatever parts of further layers are there.
TEST(MustHit, LayersDoNotCancel) {
  const Vec3 low{0.5f, 0.5f, 0}, high{0.5f, 0.5f, 1};
  const TriangleMesh mesh =
      test::make_mesh({low, {0, 0, 0}, {1, 0, 0}, {0.5f, 1.5f, 0}, high, {0, 0, 1}, {1, 0, 1}, {0.5f, 1.5f, 1}},
                      {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {4, 5, 6}, {4, 6, 7}, {4, 7, 5}});
  EXPECT_TRUE(must_hit(mesh, 0.5f, 0.5f, {0, 1, 2, 3, 4, 5}));
  EXPECT_TRUE(must_hit(mesh, 0.5f, 0.5f, {0, 1, 2, 3, 4}));
  EXPECT_FALSE(must_hit(mesh, 0.5f, 0.5f, {0, 1, 3, 4}));
}

// A fold: two triangles on the same side of their shared edge. The ray at the edge is near both, inside neither for sure.
TEST(MustHit, AFoldIsASilhouette) {
  const TriangleMesh mesh = test::make_mesh({{0, 0, 0}, {0, 1, 0}, {1, 0.5f, 0}, {1, 0.5f, 1}}, {{0, 1, 2}, {1, 0, 3}});
  EXPECT_FALSE(must_hit(mesh, 0, 0.5f, {0, 1}));
}

// Three sheets at one edge: two of them close the plane, whatever the third does.
TEST(MustHit, ThreeSheetsAtAnEdge) {
  const TriangleMesh mesh =
      test::make_mesh({{0, 0, 0}, {0, 1, 0}, {1, 0.5f, 0}, {-1, 0.5f, 0}, {1, 0.5f, 1}}, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
  EXPECT_TRUE(must_hit(mesh, 0, 0.5f, {0, 1, 2}));
  EXPECT_TRUE(must_hit(mesh, 0, 0.5f, {1, 2}));
  EXPECT_FALSE(must_hit(mesh, 0, 0.5f, {0, 2}));
}

// Positions, not indices, make an edge shared.
TEST(MustHit, DuplicateVerticesShareEdges) { EXPECT_TRUE(must_hit(test::unshared(test::square()), 0.5f, 0.5f, {0, 1})); }

}  // namespace
}  // namespace accel::validation
