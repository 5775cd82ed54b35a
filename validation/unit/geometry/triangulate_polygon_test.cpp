#include "libaccel/geometry/triangulate_polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <set>

namespace accel {
namespace {

// A polygon in a plane: points (x, y) placed at origin + x * u + y * v.
struct Plane {
  Vec3 origin{0, 0, 0}, u{1, 0, 0}, v{0, 1, 0};
};

std::vector<Vec3> place(const std::vector<std::pair<float, float>>& points, const Plane& plane = {}) {
  std::vector<Vec3> placed;
  for (const auto& [x, y] : points) placed.push_back(plane.origin + x * plane.u + y * plane.v);
  return placed;
}

std::vector<IndexTriple> triangulate(const std::vector<Vec3>& polygon) {
  std::vector<std::uint32_t> corners(polygon.size());
  std::iota(corners.begin(), corners.end(), 0u);
  std::vector<IndexTriple> triangles(polygon.size() - 2);
  EXPECT_TRUE(PolygonTriangulator().triangulate(corners, polygon, triangles.data()));
  return triangles;
}

// Twice the area, signed along z.
double area(Vec3 a, Vec3 b, Vec3 c) {
  return (double(b.x) - a.x) * (double(c.y) - a.y) - (double(b.y) - a.y) * (double(c.x) - a.x);
}

// Of a polygon in the plane z = 0 that runs counter-clockwise: the triangles add up to it and none is turned over, which for a
// partition into n - 2 triangles means that they cover it exactly once.
void expect_partition(const std::vector<Vec3>& polygon) {
  double whole = 0, parts = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) whole += area({0, 0, 0}, polygon[i], polygon[(i + 1) % polygon.size()]);
  for (const IndexTriple& t : triangulate(polygon)) {
    const double part = area(polygon[t.v0], polygon[t.v1], polygon[t.v2]);
    EXPECT_GT(part, 0) << t.v0 << ' ' << t.v1 << ' ' << t.v2;
    parts += part;
  }
  EXPECT_NEAR(parts, whole, 1e-9 * std::abs(whole));
}

TEST(TriangulatePolygon, ConvexPolygonsAreFans) {
  const std::vector<IndexTriple> t = triangulate(place({{0, 0}, {2, 0}, {3, 1}, {2, 2}, {0, 2}}));
  ASSERT_EQ(t.size(), 3u);
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(t[i].v0, 0u);
    EXPECT_EQ(t[i].v1, i + 1);
    EXPECT_EQ(t[i].v2, i + 2);
  }
}

// The quad that tinyobjloader splits wrongly: its shorter diagonal lies outside.
TEST(TriangulatePolygon, DartIsSplitAtItsReflexCorner) {
  for (std::size_t turn = 0; turn < 4; ++turn) {
    std::vector<std::pair<float, float>> dart = {{0, 0}, {1, -8}, {0, -2}, {-1, -8}};
    std::reverse(dart.begin(), dart.end());
    std::rotate(dart.begin(), dart.begin() + static_cast<std::ptrdiff_t>(turn), dart.end());
    expect_partition(place(dart));
  }
}

TEST(TriangulatePolygon, CollinearCornersGiveNoZeroAreaTriangles) {
  expect_partition(place({{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}));
  expect_partition(place({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {0, 4}}));
}

TEST(TriangulatePolygon, CombsAndSpirals) {
  std::vector<std::pair<float, float>> comb = {{0, -1}, {20, -1}};
  for (int i = 20; i >= 0; --i) comb.push_back({static_cast<float>(i), i % 2 == 0 ? 10.0f : 0.0f});
  expect_partition(place(comb));

  std::vector<std::pair<float, float>> spiral;
  for (int i = 0; i < 100; ++i) spiral.push_back({(10 + i) * std::cos(0.2f * i), (10 + i) * std::sin(0.2f * i)});
  for (int i = 99; i >= 0; --i) spiral.push_back({(8 + i) * std::cos(0.2f * i), (8 + i) * std::sin(0.2f * i)});
  expect_partition(place(spiral));
}

// A square with a square hole, joined by a bridge that is walked in both directions.
TEST(TriangulatePolygon, HoleWithBridge) {
  expect_partition(place({{0, 0}, {9, 0}, {9, 9}, {0, 9}, {0, 0}, {3, 3}, {3, 6}, {6, 6}, {6, 3}, {3, 3}}));
}

TEST(TriangulatePolygon, RandomStars) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> radius(0.01f, 1.0f);
  for (int round = 0; round < 300; ++round) {
    const int n = 4 + round % 60;
    std::vector<std::pair<float, float>> star;
    for (int i = 0; i < n; ++i) {
      const float angle = 6.2831853f * i / n, r = radius(random);
      star.push_back({r * std::cos(angle), r * std::sin(angle)});
    }
    expect_partition(place(star));
  }
}

// Orientation and shape are the same in every plane, at any scale and far from the origin.
TEST(TriangulatePolygon, AnyPlane) {
  const std::vector<std::pair<float, float>> points = {{0, 0}, {4, 0}, {4, 4}, {2, 1}, {0, 4}};
  const std::vector<IndexTriple> expected = triangulate(place(points));
  const Plane planes[] = {{{0, 0, 0}, {0, 1, 0}, {0, 0, 1}},          {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}},
                          {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}},          {{0, 0, 0}, {0, 0, -1}, {0, 1, 0}},
                          {{5, 6, 7}, {1, 1, 0}, {0, 1, 1}},          {{0, 0, 0}, {1e-18f, 0, 0}, {0, 1e-18f, 0}},
                          {{1e6f, 1e6f, 1e6f}, {1, 0, 0}, {0, 0, 1}}, {{0, 0, 0}, {1e18f, 0, 0}, {0, 1e18f, 0}}};
  for (const Plane& plane : planes) {
    const std::vector<Vec3> polygon = place(points, plane);
    const std::vector<IndexTriple> triangles = triangulate(polygon);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      EXPECT_EQ(triangles[i].v0, expected[i].v0);
      EXPECT_EQ(triangles[i].v1, expected[i].v1);
      EXPECT_EQ(triangles[i].v2, expected[i].v2);
    }
  }
}

// Whatever the polygon, every corner is used and there are n - 2 triangles.
TEST(TriangulatePolygon, HopelessPolygonsStillGiveTriangles) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const std::vector<std::vector<Vec3>> polygons = {
      place({{0, 0}, {1, 1}, {1, 0}, {0, 1}}),              // a bow tie
      place({{0, 3}, {2, -3}, {-3, 1}, {3, 1}, {-2, -3}}),  // a pentagram
      place({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}}),      // no area
      place({{1, 1}, {1, 1}, {1, 1}, {1, 1}}),              // one point
      {{0, 0, 0}, {1, 0, 0}, {nan, 1, 0}, {0, 1, 0}},
      {{0, 0, 0}, {1, 0, 0}, {inf, 1, 0}, {0, inf, 0}, {0, 1, 0}},
  };
  for (const std::vector<Vec3>& polygon : polygons) {
    std::set<std::uint32_t> used;
    for (const IndexTriple& t : triangulate(polygon)) {
      EXPECT_LT(std::max({t.v0, t.v1, t.v2}), polygon.size());
      used.insert({t.v0, t.v1, t.v2});
    }
    EXPECT_EQ(used.size(), polygon.size());
  }
}

TEST(TriangulatePolygon, LargePolygons) {
  // Convex ones are cheap at any size.
  constexpr std::size_t kCorners = 2000;
  std::vector<std::pair<float, float>> star;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const double angle = 6.283185307179586 * i / kCorners, r = i % 2 == 0 ? 2 : 1;
    star.push_back({static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle))});
  }
  expect_partition(place(star));

  // Beyond the limit, concave ones are refused, and still written.
  std::vector<Vec3> large(kMaxConcaveCorners + 2, Vec3{0, 0, 0});
  large[0] = {4, 0, 0}, large[1] = {4, 4, 0}, large[2] = {2, 1, 0}, large[3] = {0, 4, 0};
  std::vector<std::uint32_t> corners(large.size());
  std::iota(corners.begin(), corners.end(), 0u);
  std::vector<IndexTriple> triangles(large.size() - 2);
  EXPECT_FALSE(PolygonTriangulator().triangulate(corners, large, triangles.data()));
  EXPECT_EQ(triangles.back().v2, large.size() - 1);
}

}  // namespace
}  // namespace accel
