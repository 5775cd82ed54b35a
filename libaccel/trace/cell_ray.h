// A ray as the cells of kd-trees and grids see it: where it meets their planes.
//
// The distance of a plane is always (plane - org) * inv_dir, rounded, by crossing(). It is monotone in the plane, which is all
// that traversals rely on, and off by no more than the padding of triangles allows for (structure/padding.h) as long as the
// origin is not too far away. A direction component of zero, of either sign, counts as positive: its planes are at +inf above
// the origin, at -inf below it, and at NaN where they contain it.
//
// Origins that are beyond kPaddingReach: distances are measured from an anchor, the point of the ray that is nearest to the
// middle of the scene. It is computed in double, and rounded by no more than the padding's share for coordinates, so the cells
// visited are those along the ray however far away it starts. What remains is the error of the triangle tests, which grows with
// the distance: a hit by a hair beyond a triangle's edge may be found by a test of all triangles and not by traversal.
//
// Directions whose components are all below 2^-64, for which inv_dir may overflow beside hits at representable distances: they
// are scaled by 2^64.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "libaccel/core/aabb.h"
#include "libaccel/core/float_bounds.h"
#include "libaccel/core/ray.h"
#include "libaccel/structure/padding.h"

namespace accel {

struct CellRay {
  float org[3];
  float inv_dir[3];              // +inf for zero of either sign
  std::uint32_t backwards_axes;  // bit a of every byte: the ray runs towards smaller coordinates
  float t_anchor, t_unit;        // the distance t here is t_anchor + t_unit * t of the ray

  static constexpr float kTiny = 0x1p-64f;

  // For cells in a box, which is not empty.
  ACCEL_HD static CellRay prepare(const Ray& ray, const Aabb& box) {
    const bool is_tiny = largest_magnitude(ray.dir) < kTiny, is_far = is_beyond_reach(ray.org, box);
    if (is_tiny || is_far) return anchored(ray, box, is_tiny ? 1 / kTiny : 1.0f, is_far);
    return {{ray.org.x, ray.org.y, ray.org.z},
            {inverse(ray.dir.x), inverse(ray.dir.y), inverse(ray.dir.z)},
            backwards_axes_of(ray.dir),
            0.0f,
            1.0f};
  }

  // A ray's interval in distances of its cells.
  ACCEL_HD float begin(float t_min) const { return is_plain() ? t_min : (t_min * (1 - rounding()) - t_anchor) / t_unit; }
  ACCEL_HD float end(float t_max) const { return is_plain() ? t_max : (t_max * (1 + rounding()) - t_anchor) / t_unit; }

  // A distance of cells as the ray's. Hits that are nearer than that are met before, ties included; hits that are met later are
  // no nearer.
  ACCEL_HD float ray_t(float t) const { return t_anchor + t_unit * t; }

  ACCEL_HD float crossing(int axis, float plane) const {
    if (is_device_code()) return (plane - element_of_three(org, axis)) * element_of_three(inv_dir, axis);
    // GCC keeps the whole state in memory when a reference to an array in it is indexed at run time, so not by reference.
    return (plane - org[axis]) * inv_dir[axis];
  }

  // 1 where the ray runs towards smaller coordinates, else 0.
  ACCEL_HD std::uint32_t backwards(int axis) const { return backwards_axes >> axis & 1u; }

  // The faces through which the ray enters and leaves boxes.
  ACCEL_HD float entry_face(const Aabb& box, int axis) const { return either(box.lo[axis], box.hi[axis], backwards(axis)); }
  ACCEL_HD float exit_face(const Aabb& box, int axis) const { return either(box.hi[axis], box.lo[axis], backwards(axis)); }

  // Where the ray enters a box, t_begin at the earliest, and where it leaves a box that it is in, t_end at the latest. A face
  // that contains the ray (NaN) ends nothing.
  ACCEL_HD float entry(const Aabb& box, float t_begin) const {
    for (int a = 0; a < 3; ++a) t_begin = max_of(crossing(a, entry_face(box, a)), t_begin);
    return t_begin;
  }
  ACCEL_HD float exit(const Aabb& box, float t_end) const {
    for (int a = 0; a < 3; ++a) t_end = min_of(crossing(a, exit_face(box, a)), t_end);
    return t_end;
  }

 private:
  // Distances are the ray's own.
  ACCEL_HD bool is_plain() const { return t_anchor == 0 && t_unit == 1; }

  // The first for 0, the second for 1. Without a branch, since the directions of incoherent rays are anyone's guess.
  ACCEL_HD static float either(float first, float second, std::uint32_t which) {
    const auto a = std::bit_cast<std::uint32_t>(first), b = std::bit_cast<std::uint32_t>(second);
    return std::bit_cast<float>(a ^ ((a ^ b) & (0u - which)));
  }

  ACCEL_HD static float inverse(float dir) { return dir == 0 ? std::numeric_limits<float>::infinity() : 1.0f / dir; }
  ACCEL_HD static std::uint32_t backwards_axes_of(Vec3 dir) {
    return ((dir.x < 0 ? 1u : 0u) | (dir.y < 0 ? 2u : 0u) | (dir.z < 0 ? 4u : 0u)) * 0x01010101u;
  }
  ACCEL_HD static float largest_magnitude(Vec3 v) {
    return largest_component({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  }

  // Hits round to the float next to their distance, those of Moeller and Trumbore's test some floats further; beside an anchor,
  // which is far from the origin, that may be beyond the padding.
  ACCEL_HD float rounding() const { return t_anchor != 0 ? gamma(8) : 0.0f; }

  ACCEL_HD static bool is_beyond_reach(Vec3 org, const Aabb& box) {
    const Vec3 extent = box.extent(), outside = max_of(box.lo - org, org - box.hi);
    return largest_component(outside) > kPaddingReach * largest_component(extent);
  }
  ACCEL_HD static float largest_component(Vec3 v) { return max_of(max_of(v.x, v.y), v.z); }

  ACCEL_HD static CellRay anchored(const Ray& ray, const Aabb& box, float scale, bool moves) {
    CellRay result;
    result.t_unit = scale, result.t_anchor = 0;
    result.backwards_axes = backwards_axes_of(ray.dir);
    const Vec3 center = box.center();
    double along = 0, length = 0;
    for (int a = 0; a < 3; ++a) {
      const double dir = static_cast<double>(ray.dir[a]);
      along += (static_cast<double>(center[a]) - ray.org[a]) * dir, length += dir * dir;
    }
    // Not behind the origin, and not beyond the largest distance of a hit.
    const double nearest = along / length, largest = static_cast<double>(std::numeric_limits<float>::max());
    if (moves && nearest > 0) result.t_anchor = static_cast<float>(nearest < largest ? nearest : largest);
    for (int a = 0; a < 3; ++a) {
      result.org[a] = static_cast<float>(ray.org[a] + static_cast<double>(result.t_anchor) * ray.dir[a]);
      result.inv_dir[a] = inverse(ray.dir[a] * scale);
    }
    return result;
  }
};

}  // namespace accel
