// A light for scenes that come without one.
#pragma once

#include "libaccel/core/aabb.h"
#include "libaccel/core/camera_description.h"
#include "libaccel/core/light_description.h"

namespace accel {

// A horizontal square light above the centre of the scene; which way is up is read from the camera. When the eye lies inside
// the box (the scene is a room or a world around the viewer), the light hangs below the ceiling, at 90 % of the height;
// otherwise it floats half the scene's diagonal above an object. Its side is a quarter of the smaller horizontal extent, or a
// tenth of the diagonal if that is larger. An empty box counts as the unit cube.
LightDescription default_light(const Aabb& bounds, const CameraDescription& camera);

}  // namespace accel
