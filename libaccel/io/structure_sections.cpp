#include "libaccel/io/structure_sections.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "libaccel/io/scene_description.h"

namespace accel {
namespace {

using Json = nlohmann::json;

Json to_json(Vec3 v) { return {v.x, v.y, v.z}; }

Json to_json(const CameraDescription& camera) {
  return {{"name", camera.name},
          {"eye", to_json(camera.eye)},
          {"at", to_json(camera.at)},
          {"up", to_json(camera.up)},
          {"vfov", camera.vfov_degrees}};
}

Json to_json(const LightDescription& light) {
  return {{"center", to_json(light.center)}, {"half_u", to_json(light.half_u)}, {"half_v", to_json(light.half_v)}};
}

// How much of the file's vertices and triangles one mesh is.
struct MeshPart {
  std::uint64_t vertices, triangles;
};

// JSON has no word for numbers that are not finite: they are kept as null, and come back as NaN.
bool read_statistics(const Json& object, std::map<std::string, double>& out) {
  if (!object.is_object()) return false;
  for (const auto& [key, value] : object.items()) {
    if (!value.is_number() && !value.is_null()) return false;
    out[key] = value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
  }
  return true;
}

bool read_options(const Json& object, std::map<std::string, std::string>& out) {
  if (!object.is_object()) return false;
  for (const auto& [key, value] : object.items()) {
    if (!value.is_string()) return false;
    out[key] = value.get<std::string>();
  }
  return true;
}

bool read_text(const Json& object, const char* key, std::string& out) {
  if (!object.contains(key) || !object[key].is_string()) return false;
  out = object[key].get<std::string>();
  return true;
}

}  // namespace

std::uint64_t counted(const AccelMetadata& metadata, const std::string& statistic) {
  const auto found = metadata.statistics.find(statistic);
  const bool is_count = found != metadata.statistics.end() && found->second >= 0 && found->second <= 0x1p53;
  return is_count ? static_cast<std::uint64_t>(found->second) : 0;
}

void write_sections(AccelFileWriter& writer, const AccelMetadata& metadata) {
  Json root = {{"structure", metadata.structure}, {"builder", metadata.builder},       {"scene", metadata.scene},
               {"options", metadata.options},     {"statistics", metadata.statistics}, {"view", Json::object()}};
  for (const CameraDescription& camera : metadata.cameras) root["view"]["cameras"].push_back(to_json(camera));
  if (metadata.light) root["view"]["light"] = to_json(*metadata.light);
  // File names need not be UTF-8.
  writer.add_text("metadata", root.dump(2, ' ', false, Json::error_handler_t::replace));
}

Status read_sections(const AccelFile& file, AccelMetadata& metadata) {
  const Result<std::string> text = file.text("metadata");
  if (!text) return text.error();
  // Nothing that is written is nested so deep, and dump() recurses.
  const auto is_shallow = [](int depth, Json::parse_event_t, Json&) { return depth <= 64; };
  const Json root = Json::parse(*text, is_shallow, false);
  const bool good =
      root.is_object() && read_text(root, "structure", metadata.structure) && read_text(root, "builder", metadata.builder) &&
      read_text(root, "scene", metadata.scene) && root.contains("options") && read_options(root["options"], metadata.options) &&
      root.contains("statistics") && read_statistics(root["statistics"], metadata.statistics) && root.contains("view");
  if (!good) return file.error("metadata", "is not what this version writes");

  // Cameras and light have the form of a scene's sidecar.
  Result<SceneDescription> view = parse_scene_json(root["view"].dump(), file.path().string());
  if (!view) return view.error();
  metadata.cameras = std::move(view->cameras);
  metadata.light = view->light;
  return Done{};
}

void write_sections(AccelFileWriter& writer, const TriangleMesh& mesh) {
  writer.add("mesh.vertices", mesh.vertices);
  writer.add("mesh.triangles", mesh.triangles);
  writer.add_value("mesh.facts", mesh_facts(mesh));
}

Status read_sections(const AccelFile& file, TriangleMesh& mesh) {
  if (has_instances(file)) return file.error({}, "holds a scene of instances, not one mesh: read<InstancedMeshes>() reads it");
  if (Status status = take_section(file, "mesh.vertices", mesh.vertices); !status) return status;
  if (Status status = take_section(file, "mesh.triangles", mesh.triangles); !status) return status;
  return in_file(file, validate(mesh));
}

Status read_sections(const AccelFile& file, MeshFacts& facts) {
  const Result<MeshFacts> stored = file.value<MeshFacts>("mesh.facts");
  if (!stored) return stored.error();
  const std::uint64_t triangles = triangle_count(file);
  const bool all_skipped = stored->zero_area <= triangles && stored->out_of_range == triangles - stored->zero_area;
  const bool adds_up = stored->triangles == triangles && stored->zero_area <= triangles &&
                       stored->out_of_range <= triangles - stored->zero_area && stored->bounds.empty() == all_skipped;
  if (!adds_up || !(all_skipped || is_in_range({stored->bounds.lo, stored->bounds.hi, stored->bounds.hi})))
    return file.error("mesh.facts", "cannot be what the mesh contains");
  facts = *stored;
  return Done{};
}

void write_sections(AccelFileWriter& writer, const InstancedMeshes& scene) {
  std::vector<MeshPart> parts;
  std::vector<Vec3> vertices;
  std::vector<IndexTriple> triangles;
  for (const TriangleMesh& mesh : scene.meshes()) {
    parts.push_back({mesh.vertices.size(), mesh.triangles.size()});
    vertices.insert(vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    triangles.insert(triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
  }
  writer.add_copy<Vec3>("mesh.vertices", vertices);
  writer.add_copy<IndexTriple>("mesh.triangles", triangles);
  writer.add_copy<MeshPart>("scene.meshes", parts);
  writer.add("scene.instances", scene.instances());
  writer.add_value("mesh.facts", mesh_facts(scene));
}

Status read_sections(const AccelFile& file, InstancedMeshes& scene) {
  TriangleMesh all;
  Buffer<MeshPart> parts;
  Buffer<Instance> instances;
  if (Status status = take_section(file, "mesh.vertices", all.vertices); !status) return status;
  if (Status status = take_section(file, "mesh.triangles", all.triangles); !status) return status;
  if (Status status = take_section(file, "scene.meshes", parts); !status) return status;
  if (Status status = take_section(file, "scene.instances", instances); !status) return status;

  std::vector<TriangleMesh> meshes;
  std::uint64_t vertex = 0, triangle = 0;
  for (const MeshPart& part : parts) {
    if (part.vertices > all.vertices.size() - vertex || part.triangles > all.triangles.size() - triangle)
      return file.error("scene.meshes", "names more vertices or triangles than there are");
    meshes.push_back({all.vertices.part(vertex, part.vertices), all.triangles.part(triangle, part.triangles)});
    vertex += part.vertices, triangle += part.triangles;
  }
  Result<InstancedMeshes> made = InstancedMeshes::make(std::move(meshes), {instances.begin(), instances.end()});
  if (!made) return file.error({}, "holds a damaged scene: " + made.message());
  scene = *std::move(made);
  return Done{};
}

bool has_instances(const AccelFile& file) { return file.has("scene.instances"); }

std::uint64_t triangle_count(const AccelFile& file) {
  if (!has_instances(file)) return file.count("mesh.triangles");
  const auto parts = file.array<MeshPart>("scene.meshes");
  const auto instances = file.array<Instance>("scene.instances");
  std::uint64_t count = 0;
  if (parts && instances)
    for (const Instance& instance : *instances)
      if (instance.mesh < parts->size()) count += (*parts)[instance.mesh].triangles;
  return count;
}

}  // namespace accel
