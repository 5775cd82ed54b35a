#include "libaccel/io/load_scene.h"

#include <map>

#include "libaccel/core/out_of_memory.h"
#include "libaccel/io/scene_description.h"

namespace accel {
namespace {

namespace fs = std::filesystem;

// The meshes of instances, by the order in which they are first named.
class InstanceLoader {
 public:
  InstanceLoader(const fs::path& scene, const fs::path& description, const LoadOptions& options)
      : scene_(scene.lexically_normal()), folder_(description.parent_path()), description_(description), options_(options) {}

  Result<InstancedMeshes> load(const std::vector<InstanceDescription>& list) {
    std::vector<Instance> instances;
    for (const InstanceDescription& one : list) {
      const auto mesh = mesh_number(one.mesh);
      if (!mesh)
        return Error{description_.string() + ": instance " + std::to_string(instances.size() + 1) + ": " + mesh.message()};
      instances.push_back({*mesh, one.transform});
    }
    auto made = InstancedMeshes::make(std::move(meshes_), std::move(instances));
    if (!made) return Error{description_.string() + ": " + made.message()};
    return made;
  }

 private:
  Result<std::uint32_t> mesh_number(const fs::path& name) {
    const fs::path file = name.empty() ? scene_ : (folder_ / name).lexically_normal();
    const auto known = numbers_.find(file);
    if (known != numbers_.end()) return known->second;
    Result<TriangleMesh> mesh = load_mesh(file, options_);
    if (!mesh) return mesh.error();
    const auto number = static_cast<std::uint32_t>(meshes_.size());
    meshes_.push_back(*std::move(mesh));
    numbers_[file] = number;
    return number;
  }

  const fs::path scene_, folder_, description_;
  const LoadOptions& options_;
  std::vector<TriangleMesh> meshes_;
  std::map<fs::path, std::uint32_t> numbers_;
};

}  // namespace

Result<SceneData> load_scene(const std::filesystem::path& path, const LoadOptions& options) try {
  // First what is short to read: a mistake there should not wait for the mesh.
  Result<SceneDescription> description = find_scene_description(path);
  if (!description) return description.error();
  if (description->instances) {
    Result<InstancedMeshes> instances = InstanceLoader(path, description->source, options).load(*description->instances);
    if (!instances) return instances.error();
    return SceneData{{}, std::move(description->cameras), description->light, *std::move(instances)};
  }
  Result<SceneData> scene = load_file(path, options);
  if (!scene) return scene;
  scene->cameras.insert(scene->cameras.begin(), description->cameras.begin(), description->cameras.end());
  if (description->light) scene->light = description->light;
  return scene;
} catch (const std::bad_alloc&) {
  return out_of_memory("loading a scene");
}

}  // namespace accel
