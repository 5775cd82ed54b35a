// A quick look at a triangle in single precision, which settles nearly all of what geometry/mesh_facts.h decides exactly.
//
// Error bound. u = 2^-24 is the unit roundoff. Differences of floats have a relative error of at most u and do not underflow; a
// product of two of them is off by less than 3.01 u of itself, or by 2^-149 where it underflows, and the difference of two
// products by u of itself more. So where |ab - cd|, as computed, is more than 8 u (|ab| + |cd|) and more than 2^-140, the exact
// one is not zero. kShare is twice that, which covers the rounding of the bound itself. Coordinates within kMaxCoordinate have
// products below 2^125: nothing overflows.
#pragma once

#include "libaccel/core/float4_simd.h"
#include "libaccel/core/ray.h"

namespace accel {

// Whether the triangle is surely in range, is_in_range(), and surely has an area, !is_zero_area(). False says nothing: ask
// those.
inline bool is_plain_triangle(Float4 v0, Float4 v1, Float4 v2) {
  constexpr float kShare = 0x1p-20f, kLeast = 0x1p-130f;
  const auto magnitude = [](Float4 a) { return max_of(a, Float4::splat(0.0f) - a); };  // NaN stays NaN
  const Float4 sum = (magnitude(v0) + magnitude(v1)) + magnitude(v2);
  if (!xyz_less_equal(sum, Float4::splat(kMaxCoordinate))) return false;

  const Float4 e = v1 - v0, f = v2 - v0;
  const Float4 ab = e * f.yzx(), cd = e.yzx() * f;
  const Float4 bound = (magnitude(ab) + magnitude(cd)) * Float4::splat(kShare) + Float4::splat(kLeast);
  return !xyz_less_equal(magnitude(ab - cd), bound);
}

}  // namespace accel
