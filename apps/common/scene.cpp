#include "apps/common/scene.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>

#include "apps/common/text.h"
#include "libaccel/core/suggest.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/io/load_scene.h"
#include "libaccel/io/scene_description.h"
#include "libaccel/rays/camera.h"
#include "libaccel/rays/default_light.h"
#include "libaccel/registry/accel_files.h"
#include "scenes/procedural.h"

namespace accel::apps {

namespace {

constexpr std::string_view kBuiltin = "builtin:";

// The file's mesh or instances.
Result<SceneData> read_scene(const AccelFile& file) {
  SceneData data;
  if (has_instances(file)) {
    auto instances = read<InstancedMeshes>(file);
    if (!instances) return instances.error();
    data.instances = *std::move(instances);
    return data;
  }
  auto mesh = read<TriangleMesh>(file);
  if (!mesh) return mesh.error();
  data.mesh = *std::move(mesh);
  return data;
}

// The costs that the file's builder went by, without which no expected cost is comparable.
BuildOptions costs_of(const AccelMetadata& metadata) {
  BuildOptions options;
  const auto read = [&](const char* name, float& cost) {
    const auto found = metadata.options.find(name);
    if (found == metadata.options.end()) return;
    float value = 0;
    const char* const end = found->second.data() + found->second.size();
    if (std::from_chars(found->second.data(), end, value).ptr == end && value > 0) cost = value;
  };
  read("traversal_cost", options.traversal_cost), read("intersection_cost", options.intersection_cost);
  return options;
}

Outcome<Scene> open_accel_file(const std::string& path, MeshUse use) {
  const auto file = AccelFile::open(path);
  if (!file) return file.error();
  const auto metadata = read<AccelMetadata>(*file);
  if (!metadata) return metadata.error();
  const auto facts = read<MeshFacts>(*file);
  if (!facts) return facts.error();
  auto data = use == MeshUse::reads ? read_scene(*file) : Result<SceneData>(SceneData{});
  if (!data) return data.error();
  auto stored = read_structure(*file, *metadata);
  if (!stored) return stored.error();
  Scene scene;
  scene.data = *std::move(data);
  scene.data.cameras = metadata->cameras, scene.data.light = metadata->light;
  scene.facts = *facts;
  scene.stored = *std::move(stored);
  scene.stored_costs = costs_of(*metadata);
  scene.skipped_faces = accel::counted(*metadata, "skipped_faces");
  return scene;
}

Outcome<Scene> open_scene_file(const std::string& path, const Progress& progress) {
  Scene scene;
  auto data = load_scene(path, {progress, &scene.skipped_faces});
  if (!data) return data.error();
  scene.data = *std::move(data);
  scene.facts = mesh_facts(scene.triangles());
  return scene;
}

Outcome<Scene> open_builtin(const std::string& spec, std::uint64_t seed) {
  auto data = make_builtin(spec, seed);
  if (!data) return usage_error(data.message());
  Scene scene;
  scene.data = *std::move(data);
  scene.facts = mesh_facts(scene.triangles());
  return scene;
}

Outcome<Scene> open_any(const std::string& argument, std::uint64_t seed, const Progress& progress, MeshUse use) {
  if (argument.starts_with(kBuiltin)) return open_builtin(argument, seed);
  if (argument.ends_with(".accel")) return open_accel_file(argument, use);
  return open_scene_file(argument, progress);
}

// Ten numbers between commas.
Outcome<CameraDescription> parse_camera(const std::vector<std::string>& parts) {
  float value[10];
  for (std::size_t i = 0; i < 10; ++i) {
    const auto [end, error] = std::from_chars(parts[i].data(), parts[i].data() + parts[i].size(), value[i]);
    if (error != std::errc() || end != parts[i].data() + parts[i].size())
      return usage_error("--camera: '" + parts[i] + "' is not a number");
  }
  CameraDescription camera;
  camera.eye = {value[0], value[1], value[2]};
  camera.at = {value[3], value[4], value[5]};
  camera.up = {value[6], value[7], value[8]};
  camera.vfov_degrees = value[9];
  if (const Status valid = validate(camera); !valid) return usage_error("--camera: " + valid.message());
  if (const auto usable = Camera::make(camera, 1, 1); !usable) return usage_error("--camera: " + usable.message());
  return camera;
}

// One of the scene's cameras, counted from 1; its name is not one of theirs.
Outcome<CameraDescription> find_camera(const Scene& scene, const std::string& argument) {
  const std::vector<CameraDescription>& cameras = scene.data.cameras;
  if (cameras.empty()) return usage_error("--camera: scene '" + scene.name + "' has no cameras of its own; give ten numbers");
  std::vector<std::string_view> names;
  for (const CameraDescription& camera : cameras) names.push_back(camera.name);
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(argument.data(), argument.data() + argument.size(), number);
  if (error != std::errc() || end != argument.data() + argument.size())
    return usage_error("--camera: " + unknown_name("camera", argument, names).message);
  if (number < 1 || number > cameras.size())
    return usage_error("--camera: scene '" + scene.name + "' has " + counted(cameras.size(), "camera") + ", and no number " +
                       argument);
  return cameras[number - 1];
}

}  // namespace

Outcome<Scene> open_scene(const std::string& argument, std::uint64_t seed, const Progress& progress, MeshUse use) {
  const auto start = std::chrono::steady_clock::now();
  auto scene = open_any(argument, seed, progress, use);
  if (!scene) return scene;
  scene->name = argument;
  scene->title =
      argument.starts_with(kBuiltin) ? argument.substr(kBuiltin.size()) : std::filesystem::path(argument).filename().string();
  scene->load_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return scene;
}

Outcome<CameraDescription> choose_camera(const Scene& scene, const std::string& argument) {
  const std::vector<CameraDescription>& own = scene.data.cameras;
  const auto named = std::find_if(own.begin(), own.end(), [&](const CameraDescription& c) { return c.name == argument; });
  if (!argument.empty() && named != own.end()) return *named;
  const std::vector<std::string> parts = split(argument, ',');
  if (parts.size() == 10) return parse_camera(parts);
  if (parts.size() > 1)
    return usage_error("--camera: ten numbers are expected (eye, at, up, vertical angle), not " + std::to_string(parts.size()));
  if (!argument.empty()) return find_camera(scene, argument);
  if (!scene.data.cameras.empty()) return scene.data.cameras.front();
  return default_camera(scene.facts.bounds);
}

LightDescription choose_light(const Scene& scene, const CameraDescription& camera) {
  return scene.data.light ? *scene.data.light : default_light(scene.facts.bounds, camera);
}

}  // namespace accel::apps
