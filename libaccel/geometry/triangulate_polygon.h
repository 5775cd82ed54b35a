// Polygons to triangles.
//
// A polygon of n corners gives n - 2 triangles, with the polygon's orientation, whatever its shape. Strictly convex polygons
// give the fan (0, 1, 2), (0, 2, 3), …; all others are cut by ear clipping (Meisters 1975, Polygons have ears), which for a
// simple polygon covers it exactly once, never uses a diagonal that leaves it, and makes a zero-area triangle only where it has
// to. The polygon is judged in projection along the largest axis of its normal (Newell's), which drops a coordinate and rounds
// none.
//
// Where no triangulation is right (self-intersection, holes joined by crossing bridges, positions that are not finite, no
// area), some n - 2 triangles are given. Costs O(n) for convex polygons and O(n * r) for r corners that are not strictly
// convex: cutting an ear off changes only its neighbours, so at most 3 n ears are tried.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "libaccel/geometry/triangle_mesh.h"

namespace accel {

// Polygons that are not convex may have this many corners, since the cost grows with the square.
inline constexpr std::size_t kMaxConcaveCorners = 1 << 16;

// Keeps its working memory from one polygon to the next.
class PolygonTriangulator {
 public:
  // `corners` are vertex indices of the polygon, in range; writes corners.size() - 2 triangles of them to `out`. False, with
  // the fan written, when the polygon is not convex and has more than kMaxConcaveCorners corners.
  bool triangulate(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices, IndexTriple* out);

 private:
  // A corner in projection, in double precision: differences of floats of similar size are exact there.
  struct Point {
    double x, y;
  };

  // Twice the signed area of the triangle; positive when it turns to the left.
  static double turn(Point a, Point b, Point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

  bool project(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices);
  bool is_strictly_convex() const;
  double turn_at(std::uint32_t corner) const;
  bool is_ear(std::uint32_t corner) const;
  void judge(std::uint32_t corner);
  std::uint32_t take_ear();
  std::uint32_t any_convex() const;
  void unlink(std::uint32_t corner);
  void clip_ears(std::span<const std::uint32_t> corners, IndexTriple* out);

  std::vector<Point> points_;               // the polygon, turned so that its area is positive
  std::vector<std::uint32_t> next_, prev_;  // the corners that are left, as a ring
  std::vector<std::uint32_t> blockers_;     // corners that are not strictly convex: only they can lie in an ear
  std::vector<std::uint32_t> queue_;        // ears, and corners that have been ears, in the order in which they were found
  std::vector<char> is_ear_;                // by corner; false for corners that have been cut off
  std::size_t queue_head_ = 0;
  std::uint32_t some_corner_ = 0;  // one that is left
};

}  // namespace accel
