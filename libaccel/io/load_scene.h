// A scene file together with the cameras and the light that stand beside it.
#pragma once

#include "libaccel/geometry/scene_data.h"
#include "libaccel/io/load_mesh.h"

namespace accel {

// load_mesh() and find_scene_description() (io/scene_description.h) of one file. Where the description lists instances, the
// meshes that they name are loaded, each once, the scene's own only if one of them is its.
Result<SceneData> load_scene(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace accel
