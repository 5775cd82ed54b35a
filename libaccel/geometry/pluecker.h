// Ray-triangle intersection by Pluecker coordinates, with a bound of its rounding errors: the signed volumes that the ray spans
// with the triangle's edges (Shoup's formulation; Amanatides and Choi 1997; Kensler and Shirley 2006), relative to the origin.
//
// The volume of an edge from p to q is (q - p) x (q + p) . d, whose sign says on which side of the edge the ray passes. Each is
// computed with an error of at most gamma(7) times its permanent, the same sum with all terms positive: two roundings for each
// difference and sum of rounded vertices, three for the products, two for the sums. A negative volume within its bound may be
// positive, so the triangle is taken: no ray passes between two triangles, but a ray may hit both where exact arithmetic has
// one, and triangles that are small for their distance from the origin are hit by rays that miss them. Embree's ROBUST mode has
// the same test with a bound that is proportional to the triangle's area instead, which is narrower, and leaks.
//
// The rounding of v - org is not in the bound: both triangles at an edge see it alike.
//
// Deviations: no culling of back faces; t is that of the plane of the first vertex, in single precision.
#pragma once

#include <cmath>

#include "libaccel/core/float_bounds.h"
#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/geometry/packed_triangle.h"

namespace accel {

struct Pluecker {
  static constexpr const char* kName = "pluecker";

  // The error of a volume as a share of its permanent: gamma(7), and what the permanent itself may have lost to its roundings.
  static constexpr float kBound = gamma(7) * (1.0f + 2.0f * gamma(7));

  // What the test prepares once a ray: nothing.
  struct RayData {};

  ACCEL_HD static RayData prepare(const Ray&) { return {}; }

  // Whether the line of the ray meets the triangle. If so, t, u and v of `hit` are set; t may lie anywhere.
  ACCEL_HD static bool intersect(const PackedTriangle& triangle, const Ray& ray, const RayData&, Hit& hit) {
    const Triangle stored = triangle.vertices();
    const Vec3 v[3] = {stored.v0 - ray.org, stored.v1 - ray.org, stored.v2 - ray.org};

    // Volumes, each of the edge opposite the vertex of its number.
    const Volume volume[3] = {volume_of(v[1], v[2], ray.dir), volume_of(v[2], v[0], ray.dir), volume_of(v[0], v[1], ray.dir)};
    const bool front = volume[0].may_be_positive() && volume[1].may_be_positive() && volume[2].may_be_positive();
    const bool back = volume[0].may_be_negative() && volume[1].may_be_negative() && volume[2].may_be_negative();
    if (!front && !back) return false;

    const Vec3 normal = cross(v[1] - v[0], v[2] - v[0]);
    const float towards = dot(normal, ray.dir), sum = (volume[0].value + volume[1].value) + volume[2].value;
    if (!(towards != 0 && sum != 0)) return false;
    hit.t = dot(normal, v[0]) / towards;
    hit.u = clamped(volume[1].value / sum), hit.v = clamped(volume[2].value / sum);
    return true;
  }

 private:
  struct Volume {
    float value, error;

    ACCEL_HD bool may_be_positive() const { return value >= -error; }
    ACCEL_HD bool may_be_negative() const { return value <= error; }
  };

  ACCEL_HD static Volume volume_of(Vec3 p, Vec3 q, Vec3 dir) {
    const Vec3 edge = q - p, sum = q + p;
    const Vec3 e{fabsf(edge.x), fabsf(edge.y), fabsf(edge.z)}, s{fabsf(sum.x), fabsf(sum.y), fabsf(sum.z)};
    const Vec3 permanent{e.y * s.z + e.z * s.y, e.z * s.x + e.x * s.z, e.x * s.y + e.y * s.x};
    const float bound = permanent.x * fabsf(dir.x) + permanent.y * fabsf(dir.y) + permanent.z * fabsf(dir.z);
    return {dot(cross(edge, sum), dir), bound * kBound};
  }

  // A volume that is within its bound of zero may leave a coordinate outside of the triangle.
  ACCEL_HD static float clamped(float x) { return min_of(max_of(x, 0.0f), 1.0f); }
};

}  // namespace accel
