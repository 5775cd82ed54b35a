#include "libaccel/io/gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <string_view>
#include <utility>
#include <vector>

#include "libaccel/core/vec3d.h"
#include "libaccel/io/gltf_buffers.h"
#include "libaccel/io/json_cursor.h"
#include "libaccel/io/load_bytes.h"
#include "libaccel/io/progress_ticker.h"
#include "libaccel/io/scene_description.h"

namespace accel {
namespace {

// The parts of a .glb (section 4.4 of its specification), or of a .gltf, which is JSON alone.
struct Container {
  std::string_view json;
  std::optional<std::span<const std::byte>> binary;
};

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Container open_container(std::span<const std::byte> bytes) {
  constexpr std::uint32_t kJson = 0x4e4f534a, kBinary = 0x004e4942;
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  if (!text_of(bytes).starts_with("glTF")) return {text_of(bytes), {}};
  if (bytes.size() < kHeader + kChunkHeader) throw FormatError{"ends in its header"};
  if (const auto version = load<std::uint32_t>(&bytes[4]); version != 2)
    throw FormatError{"is of version " + std::to_string(version) + " of glTF; only 2 can be read"};
  const auto length = load<std::uint32_t>(&bytes[8]);
  if (length > bytes.size())
    throw FormatError{"ends early: it is stated to have " + std::to_string(length) + " bytes, and has " +
                      std::to_string(bytes.size())};
  Container container;
  std::size_t at = kHeader;
  for (int chunk = 0; chunk < 2 && at + kChunkHeader <= length; ++chunk) {
    const std::size_t size = load<std::uint32_t>(&bytes[at]);
    const auto type = load<std::uint32_t>(&bytes[at + 4]);
    at += kChunkHeader;
    if (size > length - at) throw FormatError{"a chunk goes beyond the end of the file"};
    if (chunk == 0 && type != kJson) throw FormatError{"its first chunk is no JSON"};
    if (chunk == 0)
      container.json = text_of(bytes.subspan(at, size));
    else if (type == kBinary)
      container.binary = bytes.subspan(at, size);
    at += size;
  }
  return container;
}

// An affine map in double: the maps of nodes are multiplied along their paths.
struct NodeMap {
  double m[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

  Vec3d vector(Vec3d v) const {
    const auto row = [&](const double(&r)[4]) { return r[0] * v.x + r[1] * v.y + r[2] * v.z; };
    return {row(m[0]), row(m[1]), row(m[2])};
  }
  Vec3d translation() const { return {m[0][3], m[1][3], m[2][3]}; }
  Affine rounded() const {
    Affine result;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) result.m[i][j] = static_cast<float>(m[i][j]);
    return result;
  }
};

NodeMap operator*(const NodeMap& a, const NodeMap& b) {
  NodeMap result;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 4; ++j) {
      result.m[i][j] = j == 3 ? a.m[i][3] : 0;
      for (int k = 0; k < 3; ++k) result.m[i][j] += a.m[i][k] * b.m[k][j];
    }
  return result;
}

// Scales, turns by a quaternion (x, y, z, w) of any length but zero, then moves.
NodeMap placed_by(std::span<const double> shift, std::span<const double> turn, std::span<const double> scale) {
  const double length = std::hypot(std::hypot(turn[0], turn[1]), std::hypot(turn[2], turn[3]));
  const double x = turn[0] / length, y = turn[1] / length, z = turn[2] / length, w = turn[3] / length;
  const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                          {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                          {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  NodeMap map;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) map.m[i][j] = r[i][j] * scale[j];
    map.m[i][3] = shift[i];
  }
  return map;
}

NodeMap map_of(const JsonCursor& node) {
  if (const auto matrix = node.find("matrix")) {
    const std::vector<double> columns = matrix->numbers(16);
    NodeMap map;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 4; ++j) map.m[i][j] = columns[4 * j + i];
    if (columns[3] != 0 || columns[7] != 0 || columns[11] != 0 || columns[15] != 1)
      matrix->fail("is not affine: its last row must be 0 0 0 1");
    return map;
  }
  const auto numbers_or = [&](const char* key, std::vector<double> otherwise) {
    const auto given = node.find(key);
    return given ? given->numbers(otherwise.size()) : otherwise;
  };
  const std::vector<double> turn = numbers_or("rotation", {0, 0, 0, 1});
  if (std::all_of(turn.begin(), turn.end(), [](double x) { return x == 0; })) node["rotation"].fail("must not be zero");
  return placed_by(numbers_or("translation", {0, 0, 0}), turn, numbers_or("scale", {1, 1, 1}));
}

std::optional<JsonCursor> extension(const JsonCursor& holder, const char* name) {
  const auto extensions = holder.find("extensions");
  return extensions ? extensions->find(name) : std::nullopt;
}

// Triangles of a primitive, by the numbers that OpenGL gives to its modes; other modes have none.
constexpr std::uint64_t kTriangles = 4, kStrip = 5, kFan = 6;

void add_triangles(std::uint64_t mode, std::span<const std::uint32_t> corners, std::vector<IndexTriple>& triangles) {
  if (corners.size() < 3) return;
  if (mode == kTriangles)
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  else if (mode == kStrip)  // every other triangle is turned, so that all have the same side in front
    for (std::size_t i = 0; i + 2 < corners.size(); ++i)
      triangles.push_back({corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]});
  else
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) triangles.push_back({corners[i], corners[i + 1], corners[0]});
}

class GltfReader {
 public:
  GltfReader(const JsonCursor& document, GltfBuffers buffers, const LoadOptions& options)
      : document_(document), buffers_(std::move(buffers)), ticker_(options.progress, "read") {}

  Result<SceneData> read() {
    check_version();
    check_extensions();
    for (const std::size_t root : roots()) visit_tree(root);
    Result<SceneData> scene = put_together();
    if (scene) scene->cameras = std::move(cameras_), scene->light = light_;
    return scene;
  }

 private:
  void check_version() const {
    const JsonCursor asset = document_["asset"], version = asset["version"];
    const auto least = asset.find("minVersion");
    if (!version.text().starts_with("2.") || (least && least->text() != "2.0"))
      version.fail("is " + version.text() + "; only glTF 2.0 can be read");
  }

  void check_extensions() const {
    static constexpr std::string_view kHeeded[] = {"KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_lights_punctual"};
    static constexpr std::string_view kElsewhere[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_xmp"};
    const auto required = document_.find("extensionsRequired");
    for (std::size_t i = 0; required && i < required->size(); ++i) {
      const std::string& name = (*required)[i].text();
      const bool is_heeded = std::find(std::begin(kHeeded), std::end(kHeeded), name) != std::end(kHeeded);
      const bool is_elsewhere = std::any_of(std::begin(kElsewhere), std::end(kElsewhere),
                                            [&](std::string_view prefix) { return name.starts_with(prefix); });
      if (!is_heeded && !is_elsewhere)
        throw FormatError{"requires the extension " + name + ", which is not supported; export the scene without it"};
    }
  }

  std::vector<std::size_t> numbers_below(const JsonCursor& list, std::size_t bound) const {
    std::vector<std::size_t> numbers(list.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = list[i].natural_below(bound);
    return numbers;
  }
  std::size_t count(const char* list) const {
    const auto found = document_.find(list);
    return found ? found->size() : 0;
  }
  std::vector<std::size_t> children(const JsonCursor& node) const {
    const auto list = node.find("children");
    return list ? numbers_below(*list, count("nodes")) : std::vector<std::size_t>();
  }

  std::vector<std::size_t> roots() const {
    if (count("scenes") > 0) {
      const auto chosen = document_.find("scene");
      const JsonCursor scene = document_["scenes"][chosen ? chosen->natural_below(count("scenes")) : 0];
      const auto nodes = scene.find("nodes");
      return nodes ? numbers_below(*nodes, count("nodes")) : std::vector<std::size_t>();
    }
    std::vector<bool> is_child(count("nodes"));
    for (std::size_t i = 0; i < is_child.size(); ++i)
      for (const std::size_t child : children(document_["nodes"][i])) is_child[child] = true;
    std::vector<std::size_t> result;
    for (std::size_t i = 0; i < is_child.size(); ++i)
      if (!is_child[i]) result.push_back(i);
    return result;
  }

  // Without recursion: a file may have nodes as deep as it is long.
  void visit_tree(std::size_t root) {
    struct Step {
      std::size_t node;
      NodeMap parent;
    };
    std::vector<Step> left{{root, {}}};
    seen_.resize(count("nodes"));
    while (!left.empty()) {
      const Step step = left.back();
      left.pop_back();
      const JsonCursor node = document_["nodes"][step.node];
      if (seen_[step.node]) node.fail("is reached twice: nodes must form trees");
      seen_[step.node] = true;
      const NodeMap map = step.parent * map_of(node);
      visit(node, map);
      const std::vector<std::size_t> below = children(node);
      for (auto child = below.rbegin(); child != below.rend(); ++child) left.push_back({*child, map});
    }
  }

  void visit(const JsonCursor& node, const NodeMap& map) {
    if (const auto mesh = node.find("mesh")) place(node, mesh_number(*mesh), map);
    if (const auto camera = node.find("camera")) add_camera(node, *camera, map);
    const auto light = extension(node, "KHR_lights_punctual");
    if (light && !light_) add_light((*light)["light"], map);
  }

  void place(const JsonCursor& node, std::uint32_t mesh, const NodeMap& map) {
    const auto instancing = extension(node, "EXT_mesh_gpu_instancing");
    if (!instancing) return instances_.push_back({mesh, map.rounded()});
    const JsonCursor attributes = (*instancing)["attributes"];
    const auto columns = [&](const char* key, std::size_t components) {
      const auto accessor = attributes.find(key);
      return accessor ? buffers_.floats(entry("accessors", *accessor), components) : std::vector<float>();
    };
    const std::vector<float> shifts = columns("TRANSLATION", 3), turns = columns("ROTATION", 4), scales = columns("SCALE", 3);
    const std::size_t many = std::max({shifts.size() / 3, turns.size() / 4, scales.size() / 3});
    for (const auto& [size, each] : {std::pair(shifts.size(), 3), std::pair(turns.size(), 4), std::pair(scales.size(), 3)})
      if (size != 0 && size != many * static_cast<std::size_t>(each)) attributes.fail("must have as many elements each");
    for (std::size_t i = 0; i < many; ++i) {
      std::array<double, 3> shift{0, 0, 0}, scale{1, 1, 1};
      std::array<double, 4> turn{0, 0, 0, 1};
      const auto take = [i](const std::vector<float>& from, auto& to) {
        if (!from.empty()) std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(i * to.size()), to.size(), to.begin());
      };
      take(shifts, shift), take(turns, turn), take(scales, scale);
      if (turn == std::array<double, 4>{}) attributes["ROTATION"].fail("must not be zero");
      instances_.push_back({mesh, (map * placed_by(shift, turn, scale)).rounded()});
    }
  }

  // What an index names in one of the document's lists.
  JsonCursor entry(const char* list, const JsonCursor& index) const {
    const JsonCursor entries = document_[list];
    return entries[index.natural_below(entries.size())];
  }

  // Each mesh that is placed is read once.
  std::uint32_t mesh_number(const JsonCursor& index) {
    const auto [known, is_new] = mesh_numbers_.try_emplace(index.natural(), static_cast<std::uint32_t>(meshes_.size()));
    if (is_new) meshes_.push_back(read_mesh(entry("meshes", index)));
    if (!ticker_.tick(static_cast<double>(meshes_.size()) / static_cast<double>(count("meshes"))))
      throw FormatError{std::string(kInterrupted)};
    return known->second;
  }

  TriangleMesh read_mesh(const JsonCursor& mesh) {
    std::vector<Vec3> vertices;
    std::vector<IndexTriple> triangles;
    std::map<std::uint64_t, std::uint32_t> first_vertices;  // of accessors, which primitives may share
    const JsonCursor primitives = mesh["primitives"];
    for (std::size_t p = 0; p < primitives.size(); ++p) {
      const JsonCursor primitive = primitives[p];
      const auto given = primitive.find("mode"), position = primitive["attributes"].find("POSITION");
      const std::uint64_t mode = given ? given->natural() : kTriangles;
      if (mode < kTriangles || mode > kFan || !position) continue;
      const JsonCursor accessor = entry("accessors", *position);
      if (extension(primitive, "KHR_draco_mesh_compression") && !accessor.find("bufferView"))
        primitive.fail("is compressed by KHR_draco_mesh_compression, which is not supported; export the scene without it");
      const auto [first, is_new] = first_vertices.try_emplace(position->natural(), static_cast<std::uint32_t>(vertices.size()));
      if (is_new) add_vertices(accessor, vertices);
      const std::size_t before = triangles.size();
      add_triangles(mode, corners(primitive, mode, accessor["count"].natural()), triangles);
      for (std::size_t i = before; i < triangles.size(); ++i)
        for (std::uint32_t* v : {&triangles[i].v0, &triangles[i].v1, &triangles[i].v2}) *v += first->second;
      if (triangles.size() > kMaxTriangles) mesh.fail("has more triangles than can be traced");
    }
    return {Buffer<Vec3>::copy_of(vertices), Buffer<IndexTriple>::copy_of(triangles)};
  }

  void add_vertices(const JsonCursor& accessor, std::vector<Vec3>& vertices) {
    const std::vector<float> numbers = buffers_.floats(accessor, 3);
    if (vertices.size() + numbers.size() / 3 > std::numeric_limits<std::uint32_t>::max())
      accessor.fail("makes more vertices than a mesh may have");
    for (std::size_t i = 0; i < numbers.size(); i += 3) vertices.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  }

  // The vertices that a primitive names, or all of them in their order.
  std::vector<std::uint32_t> corners(const JsonCursor& primitive, std::uint64_t mode, std::uint64_t vertices) {
    const auto index = primitive.find("indices");
    std::vector<std::uint32_t> corners(index ? 0 : vertices);
    if (index)
      corners = buffers_.indices(entry("accessors", *index));
    else
      std::iota(corners.begin(), corners.end(), 0u);
    if (mode == kTriangles && corners.size() % 3 != 0)
      primitive.fail("has " + std::to_string(corners.size()) + " corners, which is no multiple of three");
    const auto largest = std::max_element(corners.begin(), corners.end());
    if (largest != corners.end() && *largest >= vertices)
      primitive.fail("names vertex " + std::to_string(*largest) + " of " + std::to_string(vertices) + ", counted from 0");
    return corners;
  }

  // Looks down its node's z axis.
  void add_camera(const JsonCursor& node, const JsonCursor& index, const NodeMap& map) {
    const JsonCursor camera = entry("cameras", index);
    const auto lens = camera.find("perspective");
    if (!lens) return;  // orthographic
    const Vec3d eye = map.translation();
    CameraDescription result;
    result.eye = eye.to_float();
    result.at = (eye + normalized(map.vector({0, 0, -1})) * std::fmax(1.0, length(eye))).to_float();
    result.up = normalized(map.vector({0, 1, 0})).to_float();
    result.vfov_degrees = static_cast<float>((*lens)["yfov"].number() * (180 / std::numbers::pi));
    result.name = "camera " + std::to_string(cameras_.size() + 1);
    for (const JsonCursor& named : {camera, node})
      if (const auto name = named.find("name")) result.name = name->text();
    if (const Status valid = validate(result); !valid) camera.fail(valid.message());
    cameras_.push_back(std::move(result));
  }

  void add_light(const JsonCursor& index, const NodeMap& map) {
    const auto lights = extension(document_, "KHR_lights_punctual");
    if (!lights) return index.fail("names a light, but the file has none");
    const JsonCursor list = (*lights)["lights"], light = list[index.natural_below(list.size())];
    if (light["type"].text() == "directional") return;
    light_ = LightDescription{.center = map.translation().to_float(), .half_u = {}, .half_v = {}};
  }

  Result<SceneData> put_together() {
    std::uint64_t own = 0, placed = 0;
    for (const TriangleMesh& mesh : meshes_) own += mesh.size();
    for (const Instance& instance : instances_) placed += meshes_[instance.mesh].size();
    SceneData scene;
    if (instances_.size() == 1 && instances_[0].transform == Affine{}) {
      scene.mesh = meshes_[0];
      return scene;
    }
    if (placed >= kLargeMesh && placed > kMostlyCopies * own)
      if (auto made = InstancedMeshes::make(meshes_, instances_)) {
        scene.instances = *std::move(made);
        return scene;
      }
    Result<TriangleMesh> flat = flattened(meshes_, instances_);
    if (!flat) return flat.error();
    scene.mesh = *std::move(flat);
    return scene;
  }

  JsonCursor document_;
  GltfBuffers buffers_;
  ProgressTicker ticker_;
  std::vector<bool> seen_;  // nodes
  std::vector<TriangleMesh> meshes_;
  std::map<std::uint64_t, std::uint32_t> mesh_numbers_;  // by number in the file
  std::vector<Instance> instances_;
  std::vector<CameraDescription> cameras_;
  std::optional<LightDescription> light_;
};

}  // namespace

Result<SceneData> parse_gltf(std::span<const std::byte> bytes, const std::string& name, const LoadOptions& options) try {
  const Container container = open_container(bytes);
  const Result<nlohmann::json> document = parse_json(container.json, name);
  if (!document) return document.error();
  const JsonCursor root(*document);
  GltfBuffers buffers(root, container.binary, std::filesystem::path(name).parent_path(), options.progress);
  Result<SceneData> scene = GltfReader(root, std::move(buffers), options).read();
  return scene ? std::move(scene) : Error{name + ": " + scene.message()};
} catch (const FormatError& error) {
  return Error{error.message == kInterrupted ? error.message : name + ": " + error.message};
}

}  // namespace accel
