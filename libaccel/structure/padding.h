// How much thicker triangles are made when they are sorted into the cells of kd-trees and grids: why their traversers need no
// epsilon.
//
// A traversal meets planes at the rounded distances (plane - org) * inv_dir. These are monotone in the plane, so the cells that
// it visits are those along a curve which is the ray but for an error of gamma(3) |p_a - org_a| in each axis. The triangle
// tests accept hits which are off by gamma(5) of the distance of a vertex, and a rounded t adds one rounding. So a triangle is
// stored in every cell that comes within
//
//     pad_a = gamma(16) * (size_a + kPaddingReach * largest size) + gamma(2) * largest coordinate_a
//
// of it along all axes: whatever cell the curve is in when the ray hits the triangle, the triangle is in it, as long as origins
// lie within kPaddingReach times the largest extent of the scene's box from that box. So a hit with t no larger than the
// distance at which the curve leaves a cell is the nearest, and flat cells, triangles in planes and rays along planes are
// nothing special: every triangle has a thickness, and the box of the whole structure, padded likewise, is never flat.
//
// From farther away distances are measured from a point of the ray near the scene (trace/cell_ray.h). Rounding that point is
// what the coordinates' share of the pad is for, which matters in scenes that are far from the origin.
//
// Units: those of the scene. Pads are doubles, so that cells and padded triangles are compared without further rounding: sums
// of floats of one scene are exact in double, or off by far less than the pad's slack.
#pragma once

#include <cmath>

#include "libaccel/core/aabb.h"
#include "libaccel/core/float_bounds.h"
#include "libaccel/core/vec3d.h"

namespace accel {

inline constexpr float kPaddingReach = 4.0f;

// The pad of each axis, for triangles whose box is `bounds`: zero for no triangles, else positive.
inline Vec3d cell_padding(const Aabb& bounds) {
  if (bounds.empty()) return {};
  const Vec3d size = Vec3d(bounds.hi) - Vec3d(bounds.lo);
  const double largest = std::fmax(size.x, std::fmax(size.y, size.z));
  const auto pad = [&](double extent, float lo, float hi) {
    return static_cast<double>(gamma(16)) * (extent + kPaddingReach * largest) +
           static_cast<double>(gamma(2)) * std::fmax(std::fabs(lo), std::fabs(hi));
  };
  return {pad(size.x, bounds.lo.x, bounds.hi.x), pad(size.y, bounds.lo.y, bounds.hi.y), pad(size.z, bounds.lo.z, bounds.hi.z)};
}

// The box with its pad around it, rounded outward: strictly larger along all axes, even where the pad is lost beside the
// coordinates.
inline Aabb padded(const Aabb& box, Vec3d pad) {
  Aabb result;
  const double pads[3] = {pad.x, pad.y, pad.z};
  for (int a = 0; a < 3; ++a) {
    result.lo[a] = std::fmin(round_down(box.lo[a] - pads[a]), next_down(box.lo[a]));
    result.hi[a] = std::fmax(round_up(box.hi[a] + pads[a]), next_up(box.hi[a]));
  }
  return result;
}

}  // namespace accel
