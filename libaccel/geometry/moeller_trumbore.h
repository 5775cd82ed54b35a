// Ray-triangle intersection by Moeller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection".
//
// Fast and common, but not watertight: the edge functions of two triangles that share an edge are rounded differently, so rays
// aimed at the edge can pass between them (leaks) or hit both. Offered for comparison; Watertight is the default.
//
// Deviations: no epsilon on the determinant; comparisons are written so that NaN misses; bounds of u and v are inclusive.
#pragma once

#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/geometry/packed_triangle.h"

namespace accel {

struct MoellerTrumbore {
  static constexpr const char* kName = "moeller-trumbore";

  // What the test prepares once a ray: nothing.
  struct RayData {};

  ACCEL_HD static RayData prepare(const Ray&) { return {}; }

  // Whether the line of the ray meets the triangle. If so, t, u and v of `hit` are set; t may lie anywhere.
  ACCEL_HD static bool intersect(const PackedTriangle& triangle, const Ray& ray, const RayData&, Hit& hit) {
    const auto [v0, v1, v2] = triangle.vertices();
    const Vec3 e1 = v1 - v0, e2 = v2 - v0;
    const Vec3 p = cross(ray.dir, e2);
    const float det = dot(e1, p);
    if (!(det != 0.0f)) return false;
    const float inv_det = 1.0f / det;

    const Vec3 s = ray.org - v0;
    const float u = dot(s, p) * inv_det;
    if (!(u >= 0.0f && u <= 1.0f)) return false;
    const Vec3 q = cross(s, e1);
    const float v = dot(ray.dir, q) * inv_det;
    if (!(v >= 0.0f && u + v <= 1.0f)) return false;

    hit.t = dot(e2, q) * inv_det, hit.u = u, hit.v = v;
    return true;
  }
};

}  // namespace accel
