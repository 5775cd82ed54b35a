// A scene as it comes from a file or a generator: a mesh, and the views and light that its author chose.
#pragma once

#include <optional>
#include <vector>

#include "libaccel/core/camera_description.h"
#include "libaccel/core/light_description.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel {

struct SceneData {
  TriangleMesh mesh;
  std::vector<CameraDescription> cameras;  // the first is the default; empty: see default_camera() in rays/camera.h
  std::optional<LightDescription> light;   // none: see default_light() in rays/default_light.h
};

}  // namespace accel
