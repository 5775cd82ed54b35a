// Parts of triangles between parallel planes, as boxes: what spatial splits need (Stich et al. 2009, section 4.1).
//
// All boxes are conservative: they contain the part they stand for, in exact arithmetic. A point where an edge meets a plane is
// computed in single precision as p + t (q - p), t = (position - p_axis) / (q_axis - p_axis), whose error is below
// 8 u (|p| + |q|) per coordinate (four roundings in t, one each in the difference, the product and the sum; u = 2^-24), plus
// the smallest normal float, which covers products that underflow. The box of the crossing is widened by that much and cut back
// to the edge's box.
//
// ClippedPolygon works in double precision. It measures, which the end-point overlap needs, and bounds within a known error,
// which clipped kd-tree splits need.
//
// Planes belong to both sides: a part that only touches a plane has its box there.
#pragma once

#include <limits>

#include "libaccel/core/float4_simd.h"
#include "libaccel/core/float_bounds.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel {

// A triangle, prepared to be cut by planes across one axis.
class TriangleSlicer {
 public:
  TriangleSlicer(const Triangle& triangle, int axis)
      : vertices_{Float4::of(triangle.v0), Float4::of(triangle.v1), Float4::of(triangle.v2)},
        heights_{triangle.v0[axis], triangle.v1[axis], triangle.v2[axis]} {
    for (int i = 0; i < 3; ++i) inverse_[i] = 1.0f / (heights_[next(i)] - heights_[i]);
  }

  // The part of the triangle in the plane at `position`.
  Box4 section(float position) const {
    Box4 box;
    for (int i = 0; i < 3; ++i) {
      const float p = heights_[i], q = heights_[next(i)];
      if (p == position) box.extend(vertices_[i]);
      if ((p < position && position < q) || (q < position && position < p)) box.extend(crossing(i, position));
    }
    return box;
  }

  // Extends `box` by the vertices that lie between two planes or in one of them.
  void extend_by_vertices(float lo, float hi, Box4& box) const {
    for (int i = 0; i < 3; ++i)
      if (heights_[i] >= lo && heights_[i] <= hi) box.extend(vertices_[i]);
  }

 private:
  static constexpr int next(int i) { return i == 2 ? 0 : i + 1; }

  // Where the edge from vertex i meets the plane, which lies strictly between its ends.
  Box4 crossing(int i, float position) const {
    const Float4 p = vertices_[i], q = vertices_[next(i)];
    const Float4 lo = min_of(p, q), hi = max_of(p, q);
    // An edge so short that the reciprocal of its height overflows stands for itself.
    if (!(inverse_[i] >= -kLargest && inverse_[i] <= kLargest)) return {lo, hi};
    const Float4 at = p + Float4::splat((position - heights_[i]) * inverse_[i]) * (q - p);
    const Float4 magnitude = max_of(hi, Float4::splat(0.0f) - lo);  // max(|p|, |q|)
    const Float4 error = magnitude * Float4::splat(16 * kUnitRoundoff) + Float4::splat(kSmallest);
    return {min_of(max_of(at - error, lo), hi), max_of(min_of(at + error, hi), lo)};
  }

  static constexpr float kLargest = std::numeric_limits<float>::max();
  static constexpr float kSmallest = std::numeric_limits<float>::min();

  Float4 vertices_[3];
  float heights_[3];  // along the axis
  float inverse_[3];  // of the edges' heights
};

// The parts of `box` and `triangle` on both sides of a plane; empty where there is none.
struct TriangleParts {
  Box4 left, right;
};
inline TriangleParts split_bounds(const Triangle& triangle, const Box4& box, int axis, float position) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const TriangleSlicer slicer(triangle, axis);
  TriangleParts parts;
  parts.left = parts.right = slicer.section(position);
  slicer.extend_by_vertices(-kInfinity, position, parts.left);
  slicer.extend_by_vertices(position, kInfinity, parts.right);
  parts.left = intersection(parts.left, {box.lo, min_of(box.hi, box.hi.with_lane(axis, position))});
  parts.right = intersection(parts.right, {max_of(box.lo, box.lo.with_lane(axis, position)), box.hi});
  return parts;
}

// The part of a triangle in a box as a polygon, in double precision. Sutherland and Hodgman 1974, "Reentrant Polygon Clipping".
//
// Which points a cut keeps is decided exactly; a point that it adds is off by less than 8 u max|coordinate| (u = 2^-53: three
// roundings in t, which lies in [0, 1], one each in the difference, the product and the sum), whatever the slopes. So every
// point of the exact part that lies deeper than that inside of all planes is as near to the polygon, times the number of cuts.
class ClippedPolygon {
 public:
  struct Point {
    double at[3];
  };
  // The bounds of some points; inverted where there are none.
  struct Bounds {
    double lo[3] = {kInfinity, kInfinity, kInfinity}, hi[3] = {-kInfinity, -kInfinity, -kInfinity};

    bool empty() const { return !(lo[0] <= hi[0]); }
    void extend(const Point& point);
  };

  explicit ClippedPolygon(const Triangle& t);

  // Cuts away what lies outside of the closed box, or not between two planes.
  void clip(const Aabb& box);
  void clip(int axis, double lo, double hi);
  // The bounds of what would be left on the side on which sign * (coordinate - position) >= 0; sign is 1 or -1.
  Bounds bounds_of_side(int axis, double position, double sign) const;

  // 0 for a polygon that has vanished.
  double area() const;
  bool is_inside(const Aabb& box) const;
  bool empty() const { return size_ == 0; }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  static constexpr int kMaxPoints = 10;  // each of seven planes adds one point at most

  void keep_side(int axis, double position, double sign);
  // Where an edge meets a plane, from the heights of its ends above it, one of which is negative.
  static Point crossing(const Point& p, const Point& q, double p_height, double q_height, int axis, double position);

  Point points_[kMaxPoints];
  int size_ = 3;
};

}  // namespace accel
