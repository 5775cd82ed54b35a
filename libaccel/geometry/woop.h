// The test of Woop, Benthin and Wald 2013 in single precision alone, as users of the paper's algorithm have it: for comparison
// with geometry/watertight.h, which adds what is missing here.
//
// An edge function is a difference of two products. Two ways to round it:
//
//   RoundedProducts  fl(fl(a b) - fl(c d)), as in the paper: the right sign or zero. No ray passes between two triangles, but a
//                    zero counts as inside, so triangles that are tiny for their distance from the ray are hit wherever they
//                    lie. (The paper computes zeros again in double precision; Watertight does.)
//   KahanProducts    with the rounding error of c d brought back by two fused operations (Kahan; analysed by Jeannerod, Louvet
//                    and Muller 2013, whose bound is 1.5 ulp): the right sign, and zero only where the exact difference is zero
//                    or underflows. Not antisymmetric in the two products where they differ by less than its error, so that
//                    watertightness rests on the sign being right, not on the paper's argument.
//
// Deviations: no culling of back faces. t is the paper's, from the sheared vertices, with an error of many units in the last
// place for triangles that are larger than their distance. FMA is a function call on x86-64 machines compiled for the baseline:
// what the second test costs there is told by the clock, not by the number of its operations.
#pragma once

#include <cmath>

#include "libaccel/geometry/watertight.h"

namespace accel {

struct RoundedProducts {
  static constexpr const char* kName = "woop";
  // a b - c d
  ACCEL_HD static float difference(float a, float b, float c, float d) { return a * b - c * d; }
};

struct KahanProducts {
  static constexpr const char* kName = "woop-kahan";
  ACCEL_HD static float difference(float a, float b, float c, float d) {
    const float cd = c * d;
    const float error = fmaf(-c, d, cd);
    return fmaf(a, b, -cd) + error;
  }
};

template <class Products>
struct WoopTest {
  static constexpr const char* kName = Products::kName;
  using RayData = Watertight::RayData;

  ACCEL_HD static RayData prepare(const Ray& ray) { return Watertight::prepare(ray); }

  // Whether the line of the ray meets the triangle. If so, t, u and v of `hit` are set; t may lie anywhere.
  ACCEL_HD static bool intersect(const PackedTriangle& triangle, const Ray&, const RayData& ray, Hit& hit) {
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
    const float edge[3] = {Products::difference(x[2], y[1], y[2], x[1]), Products::difference(x[0], y[2], y[0], x[2]),
                           Products::difference(x[1], y[0], y[1], x[0])};
    if (!all_on_one_side(edge)) return false;
    const float det = (edge[0] + edge[1]) + edge[2];
    if (!(det != 0)) return false;
    const float b0 = edge[0] / det;
    hit.u = edge[1] / det, hit.v = edge[2] / det;
    hit.t = ((b0 * z[0] + hit.u * z[1]) + hit.v * z[2]) / ray.dir_z;
    return true;
  }
};

using Woop = WoopTest<RoundedProducts>;
using WoopKahan = WoopTest<KahanProducts>;

}  // namespace accel
