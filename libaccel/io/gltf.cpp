#include "libaccel/io/gltf.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include "libaccel/core/out_of_memory.h"
#include "libaccel/core/vec3d.h"
#include "libaccel/io/gltf_buffers.h"
#include "libaccel/io/gltf_meshes.h"
#include "libaccel/io/gltf_node_map.h"
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
  if (container.json.empty()) throw FormatError{"has no chunk of JSON"};
  return container;
}

// An attribute of instances, which may not be there.
class InstanceColumn {
 public:
  // read(index, components): the accessor's numbers.
  template <class Read>
  InstanceColumn(const JsonCursor& attributes, const char* key, std::vector<double> otherwise, const Read& read)
      : otherwise_(std::move(otherwise)) {
    if (const auto index = attributes.find(key)) numbers_ = read(*index, otherwise_.size());
  }

  std::size_t count() const { return numbers_.size() / otherwise_.size(); }
  std::vector<double> at(std::size_t i) const {
    if (numbers_.empty()) return otherwise_;
    const auto first = numbers_.begin() + static_cast<std::ptrdiff_t>(i * otherwise_.size());
    return {first, first + static_cast<std::ptrdiff_t>(otherwise_.size())};
  }

 private:
  std::vector<double> otherwise_;
  std::vector<float> numbers_;
};

class GltfReader {
 public:
  GltfReader(const JsonCursor& document, GltfBuffers& buffers, const LoadOptions& options)
      : document_(document), buffers_(buffers), ticker_(options.progress, "read"), meshes_(document, buffers, ticker_) {}

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
    if (!version.text().starts_with("2.")) version.fail("is " + version.quoted() + "; only glTF 2.0 can be read");
    if (least && least->text() != "2.0") least->fail("is " + least->quoted() + "; only glTF 2.0 can be read");
  }

  void check_extensions() const {
    static constexpr std::string_view kHeeded[] = {"KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_lights_punctual"};
    static constexpr std::string_view kElsewhere[] = {
        "KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "EXT_lights_", "KHR_animation_pointer", "KHR_xmp"};
    const auto required = document_.find("extensionsRequired");
    for (std::size_t i = 0; required && i < required->size(); ++i) {
      const std::string& name = (*required)[i].text();
      const bool is_heeded = std::find(std::begin(kHeeded), std::end(kHeeded), name) != std::end(kHeeded);
      const bool is_elsewhere = std::any_of(std::begin(kElsewhere), std::end(kElsewhere),
                                            [&](std::string_view prefix) { return name.starts_with(prefix); });
      if (!is_heeded && !is_elsewhere)
        throw FormatError{"requires the extension " + (*required)[i].quoted() +
                          ", which is not supported; export the scene without it"};
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
    std::vector<Step> left;
    const auto add = [&](std::size_t node, const NodeMap& parent) {
      if (seen_[node]) document_["nodes"][node].fail("is reached twice: nodes must form trees");
      seen_[node] = true;
      left.push_back({node, parent});
    };
    seen_.resize(count("nodes"));
    add(root, {});
    while (!left.empty()) {
      const Step step = left.back();
      left.pop_back();
      const JsonCursor node = document_["nodes"][step.node];
      const NodeMap map = step.parent * map_of(node);
      visit(node, map);
      const std::vector<std::size_t> below = children(node);
      for (auto child = below.rbegin(); child != below.rend(); ++child) add(*child, map);
    }
  }

  void visit(const JsonCursor& node, const NodeMap& map) {
    if (map.is_point()) return;  // a scale of zero hides a node: section 3.5.3
    if (const auto mesh = node.find("mesh")) {
      const std::uint32_t number = meshes_.number_of(*mesh);
      if (const auto instancing = gltf_extension(node, "EXT_mesh_gpu_instancing"))
        place_many((*instancing)["attributes"], number, map);
      else
        place(node, number, map);
    }
    if (const auto camera = node.find("camera")) add_camera(node, *camera, map);
    const auto light = gltf_extension(node, "KHR_lights_punctual");
    if (light && !light_) add_light(node, (*light)["light"], map);
  }

  void place(const JsonCursor& who, std::uint32_t mesh, const NodeMap& map) {
    buffers_.charge(1, who);
    instances_.push_back({mesh, map.rounded()});
  }

  void place_many(const JsonCursor& attributes, std::uint32_t mesh, const NodeMap& map) {
    const auto column = [&](const char* key, std::vector<double> otherwise) {
      return InstanceColumn(attributes, key, std::move(otherwise), [&](const JsonCursor& index, std::size_t n) {
        return buffers_.floats(gltf_entry(document_, "accessors", index), n);
      });
    };
    const InstanceColumn shifts = column("TRANSLATION", {0, 0, 0}), turns = column("ROTATION", {0, 0, 0, 1}),
                         scales = column("SCALE", {1, 1, 1});
    const std::size_t many = std::max({shifts.count(), turns.count(), scales.count()});
    if (many == 0) attributes.fail("has neither TRANSLATION, ROTATION nor SCALE");
    for (const InstanceColumn* each : {&shifts, &turns, &scales})
      if (each->count() != 0 && each->count() != many) attributes.fail("must have as many elements each");
    for (std::size_t i = 0; i < many; ++i) {
      const std::vector<double> turn = turns.at(i);
      if (is_zero(turn)) attributes["ROTATION"].fail("must not be zero");
      place(attributes, mesh, map * placed_by(shifts.at(i), turn, scales.at(i)));
      if (i % kInstancesBetweenTicks == 0) meshes_.tick();
    }
  }

  // Looks down its node's z axis.
  void add_camera(const JsonCursor& node, const JsonCursor& index, const NodeMap& map) {
    const JsonCursor camera = gltf_entry(document_, "cameras", index);
    const auto lens = camera.find("perspective");
    const Vec3d eye = map.translation(), ahead = map.vector({0, 0, -1}), up = map.vector({0, 1, 0});
    if (!lens) return;  // orthographic
    const JsonCursor yfov = (*lens)["yfov"];
    if (!(yfov.number() > 0 && yfov.number() < std::numbers::pi)) yfov.fail("must lie between 0 and pi");
    CameraDescription result;
    result.eye = eye.to_float();
    result.at = (eye + normalized(ahead) * std::fmax(1.0, length(eye))).to_float();
    result.up = normalized(up).to_float();
    result.vfov_degrees = static_cast<float>(yfov.number() * (180 / std::numbers::pi));
    result.name = "camera " + std::to_string(cameras_.size() + 1);
    for (const JsonCursor& named : {camera, node})
      if (const auto name = named.find("name")) result.name = name->text();
    if (const Status valid = validate(result); !valid) node.fail("its camera cannot be used: " + valid.message());
    cameras_.push_back(std::move(result));
  }

  void add_light(const JsonCursor& node, const JsonCursor& index, const NodeMap& map) {
    const auto lights = gltf_extension(document_, "KHR_lights_punctual");
    if (!lights) return index.fail("names a light, but the file has none");
    const JsonCursor list = (*lights)["lights"], light = list[index.natural_below(list.size())];
    if (light["type"].text() == "directional") return;
    light_ = LightDescription{.center = map.translation().to_float(), .half_u = {}, .half_v = {}};
    if (!in_range(light_->center)) node.fail("its light is too far away");
  }

  Result<SceneData> put_together() {
    std::vector<TriangleMesh> meshes = meshes_.take();
    std::uint64_t own = 0, placed = 0;
    for (const TriangleMesh& mesh : meshes) own += mesh.size();
    for (const Instance& instance : instances_) placed += meshes[instance.mesh].size();
    SceneData scene;
    if (are_better_apart(placed, own)) {
      Result<InstancedMeshes> made = InstancedMeshes::make(std::move(meshes), std::move(instances_));
      if (!made) return made.error();
      scene.instances = *std::move(made);
    } else if (instances_.size() == 1 && instances_[0].transform == Affine{}) {
      scene.mesh = meshes[instances_[0].mesh];
    } else {
      Result<TriangleMesh> flat = flattened(meshes, instances_);
      if (!flat) return flat.error();
      scene.mesh = *std::move(flat);
    }
    return scene;
  }

  static constexpr std::size_t kInstancesBetweenTicks = 4096;

  JsonCursor document_;
  GltfBuffers& buffers_;
  ProgressTicker ticker_;
  GltfMeshes meshes_;
  std::vector<bool> seen_;  // nodes
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
  GltfBuffers buffers(root, bytes.size(), container.binary, std::filesystem::path(name).parent_path(), options.progress);
  Result<SceneData> scene = GltfReader(root, buffers, options).read();
  return scene ? std::move(scene) : Error{name + ": " + scene.message()};
} catch (const FormatError& error) {
  return Error{error.message == kInterrupted ? error.message : name + ": " + error.message};
} catch (const std::bad_alloc&) {
  return out_of_memory("reading a glTF file");
}

}  // namespace accel
