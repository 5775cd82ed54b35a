#include "bench/bench_scenes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string_view>

#include "libaccel/io/load_mesh.h"
#include "libaccel/io/load_scene.h"
#include "libaccel/rays/camera.h"
#include "libaccel/rays/default_light.h"
#include "libaccel/registry/any_accel.h"
#include "scenes/procedural.h"

namespace accel::bench {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBuiltin = "builtin:";

std::vector<std::string> split(std::string_view list) {
  std::vector<std::string> parts;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    if (comma > 0) parts.emplace_back(list.substr(0, comma));
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  return parts;
}

template <class Number>
Status parse(std::string_view text, std::string_view option, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc{} && end == text.data() + text.size() && value > 0) return Done{};
  return Error{std::string(option) + std::string(text) + " is no positive number"};
}

std::vector<std::string> default_scenes() {
  std::vector<std::string> scenes;
  if (const char* folder = std::getenv("ACCEL_SCENES_DIR")) {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
      if (is_mesh_file_name(entry.path())) scenes.push_back(entry.path().string());
    std::sort(scenes.begin(), scenes.end());
  }
  if (scenes.empty())
    for (const BuiltinScene& scene : builtin_scenes()) scenes.push_back(std::string(kBuiltin) + std::string(scene.name));
  return scenes;
}

// "sponza" for "/scenes/sponza.ply.zst".
std::string short_name(const std::string& spec) {
  if (spec.starts_with(kBuiltin)) return spec;
  const std::string file = fs::path(spec).filename().string();
  return file.substr(0, file.find('.'));
}

Aabb bounds_of(const TriangleMesh& mesh) {
  Aabb box;
  for (const Vec3& v : mesh.vertices)
    if (in_range(v)) box.extend(v);
  return box;
}

}  // namespace

Result<Options> parse_options(int& argc, char** argv) {
  Options options;
  int kept = 1;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    Status status = Done{};
    if (argument.starts_with("--scenes="))
      options.scenes = split(argument.substr(9));
    else if (argument.starts_with("--rays="))
      status = parse(argument.substr(7), "--rays=", options.rays);
    else if (argument.starts_with("--threads="))
      status = parse(argument.substr(10), "--threads=", options.threads);
    else
      argv[kept++] = argv[i];
    if (!status) return status.error();
  }
  argc = kept;
  if (options.scenes.empty()) options.scenes = default_scenes();
  return options;
}

Result<Scene> load(const std::string& spec) {
  Result<SceneData> data = spec.starts_with(kBuiltin) ? make_builtin(spec) : load_scene(spec);
  if (!data) return data.error();
  // Rays are made from one mesh, and so is everything that does not keep instances apart.
  Result<TriangleMesh> mesh = data->one_mesh();
  if (!mesh) return mesh.error();
  data->mesh = *std::move(mesh);
  return Scene{short_name(spec), std::move(data).value()};
}

Result<AnyAccel> build(const Scene& scene, const MethodInfo& method, const BuildOptions& options) {
  return scene.data.instances && method.instances ? AnyAccel::build(*scene.data.instances, method.name, options)
                                                  : AnyAccel::build(scene.data.mesh, method.name, options);
}

Result<RaySet> make_rays(const Scene& scene, RayKind kind, std::uint64_t count) {
  const Aabb bounds = bounds_of(scene.data.mesh);
  if (kind == RayKind::random) return random_rays(bounds, count);
  if (kind == RayKind::edge) return edge_rays(scene.data.mesh, count);

  const CameraDescription view = scene.data.cameras.empty() ? default_camera(bounds) : scene.data.cameras.front();
  const auto height = static_cast<std::uint32_t>(std::max(1.0, std::sqrt(static_cast<double>(count) * 3 / 4)));
  const Result<Camera> camera = Camera::make(view, static_cast<std::uint32_t>(count / height), height);
  if (!camera) return camera.error();
  Result<RaySet> primary = primary_rays(*camera);
  if (!primary || kind == RayKind::primary) return primary;

  const Result<AnyAccel> accel = AnyAccel::build(scene.data.mesh, best_method());
  if (!accel) return accel.error();
  std::vector<Hit> hits(primary->size());
  if (Status traced = accel->closest(primary->rays.span(), hits); !traced) return traced.error();
  return secondary_rays(kind, {scene.data.mesh, *primary, hits}, scene.data.light.value_or(default_light(bounds, view)));
}

}  // namespace accel::bench
