// Watertight ray-triangle intersection: Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection", JCGT 2(1).
//
// The vertices are moved so that the ray starts at the origin and sheared so that it runs along +z; the triangle is hit when
// the three edge functions U, V, W of its projection have no two different signs. Every vertex is rounded the same way in each
// triangle that uses it, and the edge function of a shared edge is the same number with the opposite sign in both triangles, so
// a ray cannot pass between them.
//
// Why no contraction: fl(a b) - fl(c d) has the right sign or is zero, because rounding is monotone. fma(a, b, -fl(c d)) is not
// antisymmetric in its two products, and the argument falls. This file is compiled with -ffp-contract=off, on CUDA -fmad=false.
//
// An edge function that is rounded to zero has lost its sign. Counting zero as inside leaks nothing, but a triangle that is
// 2^-24 times as large as its distance from the ray would be hit wherever it lies, since all three of its edge functions may
// vanish. So a candidate with a zero is tested again in double, where the products are exact.
//
// The distance t is that of the ray to the plane of the stored vertices, computed in double and rounded once: the sheared
// vertices are rounded relative to the origin's distance from them, which would leave t with an error of many units in the last
// place wherever the triangle is larger than its distance. So t is the float next to the exact distance, hits lie where the box
// of their triangle is, and coplanar triangles tie. Exceptions: planes met at less than some 2^-25 of the distance of their
// vertices, and triangles seen edge-on, for which rounding decides whether they are hit and t lies between their vertices. Only
// accepted triangles pay for this, one or two a ray.
//
// Deviations from the paper. The double-precision test runs only for triangles that the single-precision one accepts, which
// rejects none that are hit: a nonzero edge function has the right sign. No back-face culling, hence no swap of axes for
// negative directions. t is in double, as above; no triple product of lengths is ever formed in single precision, so scenes of
// features between 2^-60 and 2^60 neither underflow nor overflow, and scaling scene and ray by 2^k scales t exactly.
//
// Errors (u = 2^-24, all bounds relative to |v - org| per axis): a sheared coordinate has an error of at most
// u |v_x - o_x| + gamma(4) |S_x (v_z - o_z)| + u |A_x|; validation/compare/error_bounds.h builds the judge's bounds on this.
#pragma once

#include <cmath>

#include "libaccel/core/float_bounds.h"
#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/geometry/packed_triangle.h"
#include "libaccel/geometry/watertight_simd.h"

namespace accel {

struct Watertight {
  static constexpr const char* kName = "watertight";

  // The ray's axis permutation and shear.
  struct RayData {
    int kx, ky, kz;             // kz is the axis of the largest direction component
    float org_x, org_y, org_z;  // the origin, permuted
    float shear_x, shear_y;     // dir[kx] / dir[kz], dir[ky] / dir[kz]
    float dir_z;                // dir[kz]
  };

  // A triangle as the ray sees it: edge functions, and depths along the axis kz relative to the origin.
  using Projection = WatertightProjection;

  ACCEL_HD static RayData prepare(const Ray& ray) {
    const int kz = largest_axis(ray.dir);
    const int kx = kz == 2 ? 0 : kz + 1;
    const int ky = kx == 2 ? 0 : kx + 1;
    const float dir_z = ray.dir[kz];
    return {kx, ky, kz, ray.org[kx], ray.org[ky], ray.org[kz], ray.dir[kx] / dir_z, ray.dir[ky] / dir_z, dir_z};
  }

  // Whether the line of the ray meets the triangle. If so, t, u and v of `hit` are set; t may lie anywhere.
  ACCEL_HD static bool intersect(const PackedTriangle& triangle, const Ray& ray, const RayData& data, Hit& hit) {
    Projection projection;
#if ACCEL_SSE
    return project_sse(triangle, data, projection) && locate(triangle, ray, data, projection, hit);
#else
    return project(triangle, data, projection) && locate(triangle, ray, data, projection, hit);
#endif
  }

  // The portable version: bit-identical to the SIMD one, which tests compare with it.
  ACCEL_HD static bool intersect_scalar(const PackedTriangle& triangle, const Ray& ray, const RayData& data, Hit& hit) {
    Projection projection;
    return project(triangle, data, projection) && locate(triangle, ray, data, projection, hit);
  }

  // The vertex whose largest difference of a coordinate is the smallest; the first of equals. Without branches, which no one
  // could predict.
  ACCEL_HD static int nearest_vertex(const PackedTriangle& triangle, Vec3 org) {
    const PackedTriangle::Quad x = triangle.coordinate(0), y = triangle.coordinate(1), z = triangle.coordinate(2);
    float d[3];
    for (int i = 0; i < 3; ++i)
      d[i] = max_of(max_of(magnitude(x.vertex[i] - org.x), magnitude(y.vertex[i] - org.y)), magnitude(z.vertex[i] - org.z));
    const int of_two = d[1] < d[0] ? 1 : 0;
    return d[2] < min_of(d[1], d[0]) ? 2 : of_two;
  }

 private:
  // Projects the triangle along the ray. Returns whether it contains the ray.
  ACCEL_HD static bool project(const PackedTriangle& triangle, const RayData& ray, Projection& p) {
    const PackedTriangle::Quad qx = triangle.coordinate(ray.kx);
    const PackedTriangle::Quad qy = triangle.coordinate(ray.ky);
    const PackedTriangle::Quad qz = triangle.coordinate(ray.kz);

    // Vertices relative to the origin, sheared into the ray's frame.
    float x[3], y[3];
    for (int i = 0; i < 3; ++i) {
      p.z[i] = qz.vertex[i] - ray.org_z;
      x[i] = (qx.vertex[i] - ray.org_x) - ray.shear_x * p.z[i];
      y[i] = (qy.vertex[i] - ray.org_y) - ray.shear_y * p.z[i];
    }

    // Edge functions, each opposite the vertex of its number.
    p.edge[0] = x[2] * y[1] - y[2] * x[1];
    p.edge[1] = x[0] * y[2] - y[0] * x[2];
    p.edge[2] = x[1] * y[0] - y[1] * x[0];
    if (!all_on_one_side(p.edge)) return false;
    if (p.edge[0] != 0 && p.edge[1] != 0 && p.edge[2] != 0) return true;
    refine_edge_functions(x, y, p.edge);
    return all_on_one_side(p.edge);
  }

  // Where the ray meets a triangle whose projection contains it; false where they are parallel.
  ACCEL_HD static bool locate(const PackedTriangle& triangle, const Ray& ray, const RayData& data, const Projection& p,
                              Hit& hit) {
    const float det = (p.edge[0] + p.edge[1]) + p.edge[2];
    if (!(det != 0)) return false;
    const float b0 = p.edge[0] / det;
    hit.u = p.edge[1] / det, hit.v = p.edge[2] / det;

    // The plane's distance, unless it is beyond the triangle's vertices, which are rounded once: where the triangle is seen
    // edge-on, or by a hair beyond a vertex, rounding decides about its projection, and the plane may be met anywhere.
    const double t = plane_distance(triangle, ray), depth = t * data.dir_z;
    const float nearest = min_of(min_of(p.z[0], p.z[1]), p.z[2]), farthest = max_of(max_of(p.z[0], p.z[1]), p.z[2]);
    const bool within = depth >= nearest - kUnitRoundoff * 2 * magnitude(nearest) &&
                        depth <= farthest + kUnitRoundoff * 2 * magnitude(farthest);
    hit.t = within ? static_cast<float>(t) : ((b0 * p.z[0] + hit.u * p.z[1]) + hit.v * p.z[2]) / data.dir_z;
    return true;
  }

  ACCEL_HD static float magnitude(float x) { return std::fabs(x); }

  // n . (v - org) / n . dir for the normal n and the vertex v that is nearest to the origin, which makes the distance of a
  // vertex that is the origin exactly 0; NaN or infinite where the ray is parallel to the plane.
  ACCEL_HD static double plane_distance(const PackedTriangle& triangle, const Ray& ray) {
    const int nearest = nearest_vertex(triangle, ray.org);
    double e1[3], e2[3], s[3];
    for (int a = 0; a < 3; ++a) {
      const PackedTriangle::Quad q = triangle.coordinate(a);
      const double v0 = q.vertex[0];
      e1[a] = q.vertex[1] - v0, e2[a] = q.vertex[2] - v0;
      s[a] = static_cast<double>(element_of_three(triangle.axis[a].vertex, nearest)) - ray.org[a];
    }
    const double nx = e1[1] * e2[2] - e1[2] * e2[1], ny = e1[2] * e2[0] - e1[0] * e2[2], nz = e1[0] * e2[1] - e1[1] * e2[0];
    return (nx * s[0] + ny * s[1] + nz * s[2]) / (nx * ray.dir.x + ny * ray.dir.y + nz * ray.dir.z);
  }
};

}  // namespace accel
