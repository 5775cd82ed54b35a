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
// Deviations from the paper. The double-precision test runs only for triangles that the single-precision one accepts, which
// rejects none that are hit: a nonzero edge function has the right sign. No back-face culling, hence no swap of axes for
// negative directions. The barycentric coordinates are divided out before t is formed, so that t needs no triple product of
// lengths: scenes of features between 2^-60 and 2^60 neither underflow nor overflow, and scaling scene and ray by 2^k scales t
// exactly.
//
// Errors (u = 2^-24, all bounds relative to |v - org| per axis): a sheared coordinate has an error of at most
// u |v_x - o_x| + gamma(4) |S_x (v_z - o_z)| + u |A_x|; validation/compare/error_bounds.h builds the judge's bounds on this.
#pragma once

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

  ACCEL_HD static RayData prepare(const Ray& ray) {
    const int kz = largest_axis(ray.dir);
    const int kx = kz == 2 ? 0 : kz + 1;
    const int ky = kx == 2 ? 0 : kx + 1;
    const float dir_z = ray.dir[kz];
    return {kx, ky, kz, ray.org[kx], ray.org[ky], ray.org[kz], ray.dir[kx] / dir_z, ray.dir[ky] / dir_z, dir_z};
  }

  // Whether the line of the ray meets the triangle. If so, t, u and v of `hit` are set; t may lie anywhere.
  ACCEL_HD static bool intersect(const PackedTriangle& triangle, const Ray&, const RayData& ray, Hit& hit) {
#if ACCEL_SSE
    return watertight_sse(triangle, ray, hit);
#else
    return intersect_scalar(triangle, ray, hit);
#endif
  }

  // The portable version: bit-identical to the SIMD ones, which tests compare with it.
  ACCEL_HD static bool intersect_scalar(const PackedTriangle& triangle, const RayData& ray, Hit& hit) {
    const PackedTriangle::Quad qx = triangle.coordinate(ray.kx);
    const PackedTriangle::Quad qy = triangle.coordinate(ray.ky);
    const PackedTriangle::Quad qz = triangle.coordinate(ray.kz);

    // Vertices relative to the origin, sheared into the ray's frame.
    float x[3], y[3], z[3];
    for (int i = 0; i < 3; ++i) {
      z[i] = qz.vertex[i] - ray.org_z;
      x[i] = (qx.vertex[i] - ray.org_x) - ray.shear_x * z[i];
      y[i] = (qy.vertex[i] - ray.org_y) - ray.shear_y * z[i];
    }

    // Edge functions, each opposite the vertex of its number.
    float uvw[3] = {x[2] * y[1] - y[2] * x[1], x[0] * y[2] - y[0] * x[2], x[1] * y[0] - y[1] * x[0]};
    if (!all_on_one_side(uvw)) return false;
    if (uvw[0] == 0 || uvw[1] == 0 || uvw[2] == 0) {
      refine_edge_functions(x, y, uvw);
      if (!all_on_one_side(uvw)) return false;
    }
    const float det = (uvw[0] + uvw[1]) + uvw[2];
    if (!(det != 0)) return false;

    const float b0 = uvw[0] / det, b1 = uvw[1] / det, b2 = uvw[2] / det;
    hit.t = ((b0 * z[0] + b1 * z[1]) + b2 * z[2]) / ray.dir_z;
    hit.u = b1, hit.v = b2;
    return true;
  }
};

}  // namespace accel
