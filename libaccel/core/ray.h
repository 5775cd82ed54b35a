// Rays: a closed interval of a half-line.
//
// A ray is the set of points org + t * dir for t in the closed interval [max(t_min, 0), t_max]; dir need not have unit length,
// and t is measured in units of dir. Rays that describe no such set hit nothing, by definition and in every method: see
// is_traceable().
#pragma once

#include <limits>
#include <type_traits>

#include "libaccel/core/vec3.h"

namespace accel {

// The largest magnitude of a coordinate, of an origin and of a direction, that the library accepts. It is Embree's limit too
// (FLT_LARGE), so that whatever one of them drops the other drops.
inline constexpr float kMaxCoordinate = 1.844e18f;

struct alignas(32) Ray {
  Vec3 org;
  float t_min = 0.0f;
  Vec3 dir;
  float t_max = std::numeric_limits<float>::infinity();
};
static_assert(sizeof(Ray) == 32 && std::is_trivially_copyable_v<Ray>, "files and devices rely on this layout");

// Whether every component has a magnitude within the library's range. False for NaN.
ACCEL_HD bool in_range(Vec3 v) {
  return v.x >= -kMaxCoordinate && v.x <= kMaxCoordinate && v.y >= -kMaxCoordinate && v.y <= kMaxCoordinate &&
         v.z >= -kMaxCoordinate && v.z <= kMaxCoordinate;
}

// Whether the ray is a non-empty set of points: origin and direction in range, direction not zero, interval not empty and not
// NaN. All other rays are misses.
ACCEL_HD bool is_traceable(const Ray& ray) {
  return in_range(ray.org) && in_range(ray.dir) && (ray.dir.x != 0 || ray.dir.y != 0 || ray.dir.z != 0) &&
         ray.t_min <= ray.t_max && ray.t_max >= 0;
}

}  // namespace accel
