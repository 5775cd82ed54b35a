// Ray-triangle intersection by a precomputed transform: Baldwin and Weber 2016, "Fast Ray-Triangle Intersections by Coordinate
// Transformation", JCGT 5(3).
//
// The affine map that takes the triangle to the unit triangle of the plane w = 0 has a free direction: the axis `a` of the
// largest component of the normal. Then one coefficient of each row is 0 or 1, and nine are left, as many as there are
// coordinates: transforms take the place of vertices in the leaves (structure/transform_triangles.h), and the axis that of a
// word that is zero. With b and c the axes behind a:
//
//     u = u_b p_b + u_c p_c + u_0      v = v_b p_b + v_c p_c + v_0      w = p_a + w_b p_b + w_c p_c + w_0
//
// Not watertight, and coarser than Moeller and Trumbore's test: the constants u_0, v_0 and w_0 are rounded relative to the
// distance of the triangle from the scene's origin, not from the ray's. Coefficients are computed in double and rounded once.
// Triangles without a normal get NaN, which every ray misses.
#pragma once

#include <cmath>
#include <limits>

#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/geometry/packed_triangle.h"

namespace accel {

struct BaldwinWeber {
  static constexpr const char* kName = "baldwin-weber";

  // What the test prepares once a ray: nothing.
  struct RayData {};

  ACCEL_HD static RayData prepare(const Ray&) { return {}; }

  // What intersect() wants in place of a triangle: {u_b, u_c, u_0}, {v_b, v_c, v_0}, {w_b, w_c, w_0}, the prim_id, and the
  // axis.
  static PackedTriangle prepare_triangle(const PackedTriangle& triangle) {
    double origin[3], e1[3], e2[3], n[3];
    for (int i = 0; i < 3; ++i) {
      const auto& q = triangle.axis[i].vertex;
      origin[i] = q[0], e1[i] = static_cast<double>(q[1]) - q[0], e2[i] = static_cast<double>(q[2]) - q[0];
    }
    for (int i = 0; i < 3; ++i) n[i] = e1[kNext[i]] * e2[kNext[i + 1]] - e1[kNext[i + 1]] * e2[kNext[i]];
    int a = 0;
    for (int i = 1; i < 3; ++i) a = std::fabs(n[i]) > std::fabs(n[a]) ? i : a;
    const int b = kNext[a], c = kNext[a + 1];

    PackedTriangle result = triangle;
    result.axis[1].word = static_cast<std::uint32_t>(a);
    if (!(std::fabs(n[a]) > 0)) {
      for (PackedTriangle::Quad& row : result.axis)
        for (float& x : row.vertex) x = std::numeric_limits<float>::quiet_NaN();
      return result;
    }
    const double rows[3][2] = {{e2[c] / n[a], -e2[b] / n[a]}, {-e1[c] / n[a], e1[b] / n[a]}, {n[b] / n[a], n[c] / n[a]}};
    for (int r = 0; r < 3; ++r) {
      const double constant = -(rows[r][0] * origin[b] + rows[r][1] * origin[c] + (r == 2 ? origin[a] : 0.0));
      result.axis[r].vertex[0] = static_cast<float>(rows[r][0]), result.axis[r].vertex[1] = static_cast<float>(rows[r][1]);
      result.axis[r].vertex[2] = static_cast<float>(constant);
    }
    return result;
  }

  // Whether the line of the ray meets the triangle whose transform this is. If so, t, u and v of `hit` are set.
  ACCEL_HD static bool intersect(const PackedTriangle& transform, const Ray& ray, const RayData&, Hit& hit) {
    const PackedTriangle::Quad u = transform.coordinate(0), v = transform.coordinate(1), w = transform.coordinate(2);
    const int a = static_cast<int>(v.word), b = a == 2 ? 0 : a + 1, c = b == 2 ? 0 : b + 1;
    const float org_b = ray.org[b], org_c = ray.org[c], dir_b = ray.dir[b], dir_c = ray.dir[c];
    const float height = ray.org[a] + w.vertex[0] * org_b + w.vertex[1] * org_c + w.vertex[2];
    const float descent = ray.dir[a] + w.vertex[0] * dir_b + w.vertex[1] * dir_c;
    const float t = -height / descent;

    const float p_b = org_b + t * dir_b, p_c = org_c + t * dir_c;
    hit.u = u.vertex[0] * p_b + u.vertex[1] * p_c + u.vertex[2];
    if (!(hit.u >= 0)) return false;
    hit.v = v.vertex[0] * p_b + v.vertex[1] * p_c + v.vertex[2];
    if (!(hit.v >= 0 && hit.u + hit.v <= 1)) return false;
    hit.t = t;
    return true;
  }

 private:
  static constexpr int kNext[4] = {1, 2, 0, 1};
};

}  // namespace accel
