// An area light as scene files describe it: what shadow rays are aimed at. It is no geometry and blocks nothing.
#pragma once

#include "libaccel/core/vec3.h"

namespace accel {

// The parallelogram center + a * half_u + b * half_v for a, b in [-1, 1]. Hard shadows use its centre. Place it a little off
// the surface of a lamp: shadow rays end at the light, and what lies exactly there blocks them.
struct LightDescription {
  Vec3 center;
  Vec3 half_u, half_v;
};

}  // namespace accel
