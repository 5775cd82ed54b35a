// Rays that go through a point exactly, where floats permit it.
#pragma once

#include "libaccel/core/ray.h"
#include "libaccel/core/vec3d.h"

namespace accel {

// A ray with org + 1 * dir == target: dir is the rounded difference, and the origin takes up its error.
inline Ray aim(Vec3 org, Vec3 target) {
  const Vec3 dir = (Vec3d(target) - Vec3d(org)).to_float();
  return {.org = (Vec3d(target) - Vec3d(dir)).to_float(), .dir = dir};
}

}  // namespace accel
