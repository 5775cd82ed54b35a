// A pinhole camera as scene files and command lines describe it; libaccel/rays/camera.h makes rays from it.
#pragma once

#include <string>

#include "libaccel/core/vec3.h"

namespace accel {

// Looks from `eye` towards `at`, with `up` upwards in the picture (need not be perpendicular to the view). Scene units.
struct CameraDescription {
  Vec3 eye{0.0f, 0.0f, 1.0f};
  Vec3 at{0.0f, 0.0f, 0.0f};
  Vec3 up{0.0f, 1.0f, 0.0f};
  float vfov_degrees = 45.0f;  // the full vertical angle of view, between 0 and 180
  std::string name;            // how users choose among a scene's cameras; may be empty
};

}  // namespace accel
