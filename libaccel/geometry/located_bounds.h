// Bounds of t as Watertight::locate() (geometry/watertight.h) finds it, in single precision: any-hit queries ask no more than
// on which side of a limit a hit lies, and these bounds mostly tell, for a third of what t costs. Where they do not, t does.
//
// t is the plane's distance n . (v - org) / n . dir in double, rounded once, if that lies between the distances of the vertices
// along the axis kz, which is tested with a tolerance; else it is a mean of these distances. So it never lies beyond them by
// more than their rounding, and it is near the plane's distance in floats if that lies between them by more than its error.
//
// The error. Let u = 2^-24, |.| be the 1-norm, and n = e1 x e2, so that |n| <= |e1| |e2|.
//   s = n . (v - org) in floats: five roundings of each product, E_s = 5 u sum |n_a (v_a - org_a)|
//   d = n . dir in floats: four, E_d = 4 u |n| |dir_z|, as no component is larger than the one along kz
//   both in double, with another vertex for v: less than 2^-50 |e1| |e2| times the largest |v_a - org_a|, and |dir_z|
//   so s / d is off by (E_s + |s / d| E_d) / (|d| - E_d), or 8/7 (E_s + |s / d| E_d) / |d| where E_d <= |d| / 8
//   quotient, limits and the quotient in double are rounded by 4 u |s / d| <= 4 u |s / d| |n| |dir_z| / |d|
// which the constants have room for, |s / d| |dir_z| being the depth. Vertices' distances z / dir_z and their means are off by
// at most 8 u of the largest.
//
// All this holds if nothing overflows, and what underflows is less than the rest: for other sizes there are no bounds.
#pragma once

#include <cmath>
#include <limits>

#include "libaccel/core/aabb.h"
#include "libaccel/core/float_bounds.h"
#include "libaccel/core/ray.h"
#include "libaccel/geometry/packed_triangle.h"

namespace accel {

// Of a triangle, for many rays.
struct LocatedBounds {
  static constexpr float kOfProducts = 6 * kUnitRoundoff, kOfVertices = 16 * kUnitRoundoff, kOfUnderflow = 0x1p-110f;

  // What bounds |v_a - org_a|, for triangles in the box `scene` and rays whose origins have no larger coordinate than
  // `largest_origin` and whose directions have components from `least_dir` to `most_dir` along kz, all as magnitudes; infinite
  // where there are no bounds.
  static float reach(const Aabb& scene, float largest_origin, float least_dir, float most_dir) {
    constexpr float kDir = 0x1p30f, kCoordinate = 0x1p40f;
    float largest = largest_origin;
    for (int a = 0; a < 3; ++a) largest = max_of(max_of(std::fabs(scene.lo[a]), std::fabs(scene.hi[a])), largest);
    const bool exist = largest >= 1 / kCoordinate && largest <= kCoordinate && least_dir >= 1 / kDir && most_dir <= kDir;
    return exist ? 2 * largest : std::numeric_limits<float>::infinity();
  }

  Vec3 normal;
  float of_doubles;  // in E_s
  float of_depth;    // times the depth: what E_d and the rounding of t come to
  float least_d;     // times |dir_z|: from here on, E_d <= |d| / 8

  LocatedBounds() = default;
  // `n` is (v1 - v0) x (v2 - v0) in double, and `edges` the product of their 1-norms.
  LocatedBounds(const double n[3], double edges, float reach)
      : normal{static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])} {
    const auto size = static_cast<float>(edges);
    of_doubles = 0x1p-48f * reach * size, of_depth = 10 * kUnitRoundoff * size;
    least_d = size >= 0x1p-50f && size <= 0x1p60f ? 40 * kUnitRoundoff * size : std::numeric_limits<float>::infinity();
  }

  struct Interval {
    float least, most;
  };

  // Where t lies for a ray that meets the triangle; kz is the axis of the largest component of its direction.
  Interval of(const PackedTriangle& triangle, const Ray& ray, int kz) const {
    float s = 0, d = 0, products = 0;
    for (int a = 0; a < 3; ++a) {
      const float product = normal[a] * (triangle.axis[a].vertex[0] - ray.org[a]);
      s += product, products += std::fabs(product), d += normal[a] * ray.dir[a];
    }
    const float inv_d = 1 / d, t = s * inv_d, depth = s * (ray.dir[kz] * inv_d);
    const float error = (products * kOfProducts + of_doubles + std::fabs(depth) * of_depth) * std::fabs(inv_d);

    float nearest = std::numeric_limits<float>::infinity(), farthest = -nearest;
    for (const float v : triangle.axis[kz].vertex) {
      const float at = (v - ray.org[kz]) * (1 / ray.dir[kz]);
      nearest = min_of(at, nearest), farthest = max_of(at, farthest);
    }
    const float slack = max_of(std::fabs(nearest), std::fabs(farthest)) * kOfVertices + kOfUnderflow;
    const float least = t - error, most = t + error;
    const bool is_plane =
        std::fabs(d) >= least_d * std::fabs(ray.dir[kz]) && least - slack >= nearest && most + slack <= farthest;
    return is_plane ? Interval{least, most} : Interval{nearest - slack, farthest + slack};
  }
};

}  // namespace accel
