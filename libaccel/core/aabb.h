// Axis-aligned bounding boxes.
#pragma once

#include <limits>

#include "libaccel/core/vec3.h"

namespace accel {

// The closed box [lo, hi]. A default-constructed box is empty: lo = +inf, hi = -inf, the identity of extend().
struct Aabb {
  Vec3 lo{std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
          std::numeric_limits<float>::infinity()};
  Vec3 hi{-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
          -std::numeric_limits<float>::infinity()};

  ACCEL_HD bool empty() const { return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z); }
  ACCEL_HD void extend(Vec3 p) { lo = min_of(p, lo), hi = max_of(p, hi); }
  ACCEL_HD void extend(const Aabb& b) { lo = min_of(b.lo, lo), hi = max_of(b.hi, hi); }
  ACCEL_HD bool contains(const Aabb& b) const {
    return lo.x <= b.lo.x && lo.y <= b.lo.y && lo.z <= b.lo.z && hi.x >= b.hi.x && hi.y >= b.hi.y && hi.z >= b.hi.z;
  }
  ACCEL_HD Vec3 extent() const { return hi - lo; }
  ACCEL_HD Vec3 center() const { return lo * 0.5f + hi * 0.5f; }

  // Half the surface area, in square scene units; 0 for an empty box.
  ACCEL_HD float half_area() const {
    if (empty()) return 0.0f;
    const Vec3 e = extent();
    return e.x * (e.y + e.z) + e.y * e.z;
  }
};

// Half the surface area without overflow and with next to no rounding: in single precision large scenes lose the small boxes.
// 0 for an empty box.
ACCEL_HD double half_area_in_double(const Aabb& b) {
  if (b.empty()) return 0.0;
  const double x = static_cast<double>(b.hi.x) - b.lo.x, y = static_cast<double>(b.hi.y) - b.lo.y,
               z = static_cast<double>(b.hi.z) - b.lo.z;
  return x * (y + z) + y * z;
}

// The box of the points that lie in both boxes; empty() when there are none.
ACCEL_HD Aabb intersection(const Aabb& a, const Aabb& b) { return {max_of(a.lo, b.lo), min_of(a.hi, b.hi)}; }

}  // namespace accel
