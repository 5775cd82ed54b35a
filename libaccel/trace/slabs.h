// How a box test computes the distances to planes, and what it allows for their rounding: the slab test's variants.
//
//   PaddedSlabs  (plane - org) * inv_dir, far distances scaled by what trace/box_pair.h derives: enters every box with a hit.
//   NaiveSlabs   the same without the scale: a box that is met in an edge may be missed.
//   FusedSlabs   plane * inv_dir - org * inv_dir in one fused operation, without a scale: an operation less. The error is one
//   of
//                org * inv_dir, which may be any multiple of the distance. Along axes that the ray does not move along both
//                products may be infinite: their difference is NaN, which restricts nothing, on either side of the box.
//
// The last two lose hits; they are here to be measured.
#pragma once

#include <cmath>

#include "libaccel/core/float_bounds.h"
#include "libaccel/core/hd.h"
#include "libaccel/trace/box_pair.h"

namespace accel {

struct PaddedSlabs {
  static constexpr bool kIsRobust = true;
  static constexpr bool kIsFused = false;
  // Of the reciprocals for far planes, one rounding more than in box_pair.h; and of the interval's end.
  static constexpr float kFarPlaneScale = 1.0f + 2.0f * gamma(9);
  static constexpr float kEndScale = kFarScale;
};

struct NaiveSlabs {
  static constexpr bool kIsRobust = false;
  static constexpr bool kIsFused = false;
  static constexpr float kFarPlaneScale = 1.0f;
  static constexpr float kEndScale = 1.0f;
};

// Infinite boxes, which absent children have, may give nothing but NaN: whether there is a child must be looked up.
struct FusedSlabs {
  static constexpr bool kIsRobust = false;
  static constexpr bool kIsFused = true;
  static constexpr float kFarPlaneScale = 1.0f;
  static constexpr float kEndScale = 1.0f;
};

// The distance to a plane.
template <class Slabs>
ACCEL_HD float plane_distance(float plane, float org, float inv_dir) {
  if constexpr (Slabs::kIsFused)
    return fmaf(plane, inv_dir, -(org * inv_dir));
  else
    return (plane - org) * inv_dir;
}

}  // namespace accel
