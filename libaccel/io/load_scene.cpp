#include "libaccel/io/load_scene.h"

#include "libaccel/io/scene_description.h"

namespace accel {

Result<SceneData> load_scene(const std::filesystem::path& path, const LoadOptions& options) {
  // First what is short to read: a mistake there should not wait for the mesh.
  Result<SceneDescription> description = find_scene_description(path);
  if (!description) return description.error();
  Result<TriangleMesh> mesh = load_mesh(path, options);
  if (!mesh) return mesh.error();
  return SceneData{*std::move(mesh), std::move(description->cameras), description->light};
}

}  // namespace accel
