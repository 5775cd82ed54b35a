// A scene file together with the cameras and the light that stand beside it.
#pragma once

#include "libaccel/geometry/scene_data.h"
#include "libaccel/io/load_mesh.h"

namespace accel {

// load_file() and find_scene_description() (io/scene_description.h) of one file. The description's cameras come before the
// file's own, and its light in place of the file's. Where it lists instances, the meshes that they name are loaded, each once,
// the scene's own only if one of them is its.
Result<SceneData> load_scene(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace accel
