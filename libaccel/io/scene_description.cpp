#include "libaccel/io/scene_description.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <string>

#include "libaccel/core/out_of_memory.h"
#include "libaccel/core/suggest.h"
#include "libaccel/io/input_bytes.h"
#include "libaccel/io/json_cursor.h"

namespace accel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

bool is_finite(Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// Reads one JSON description. The first mistake ends the reading; `where` names the part that is being read.
class JsonReader {
 public:
  explicit JsonReader(const std::string& name) : name_(name) {}

  Result<SceneDescription> read(std::string_view text) {
    const Result<Json> parsed = parse_json(text, name_);
    if (!parsed) return parsed.error();
    const Json& root = *parsed;
    SceneDescription scene;
    if (check_keys(root, {"cameras", "light", "instances"})) {
      if (root.contains("cameras")) cameras(root["cameras"], scene);
      if (root.contains("light")) where_ = "light", light(root["light"], scene);
      if (root.contains("instances")) instances(root["instances"], scene);
    }
    if (!message_.empty()) return Error{message_};
    return scene;
  }

 private:
  bool fail(const std::string& what) {
    if (message_.empty()) message_ = name_ + ": " + (where_.empty() ? "" : where_ + ": ") + what;
    return false;
  }

  bool check_keys(const Json& object, std::initializer_list<std::string_view> known) {
    if (!object.is_object()) return fail("must be an object in braces");
    const std::vector<std::string_view> names(known);
    for (const auto& [key, value] : object.items())
      if (std::find(names.begin(), names.end(), key) == names.end()) return fail(unknown_name("key", key, names).message);
    return true;
  }

  bool number(const Json& object, const char* key, float& out) {
    if (!object.contains(key)) return true;
    if (!object[key].is_number()) return fail(std::string(key) + " must be a number");
    out = object[key].get<float>();
    return true;
  }

  bool vector(const Json& object, const char* key, Vec3& out, bool required) {
    if (!object.contains(key)) return !required || fail(std::string(key) + " is missing");
    const Json& values = object[key];
    const bool good = values.is_array() && values.size() == 3 &&
                      std::all_of(values.begin(), values.end(), [](const Json& value) { return value.is_number(); });
    if (good) out = {values[0].get<float>(), values[1].get<float>(), values[2].get<float>()};
    return (good && is_finite(out)) || fail(std::string(key) + " must be three numbers in brackets");
  }

  bool camera(const Json& object, CameraDescription& out) {
    if (!check_keys(object, {"name", "eye", "at", "up", "vfov"})) return false;
    if (object.contains("name") && !object["name"].is_string()) return fail("name must be a string");
    out.name = object.value("name", where_);
    const bool read = vector(object, "eye", out.eye, true) && vector(object, "at", out.at, true) &&
                      vector(object, "up", out.up, false) && number(object, "vfov", out.vfov_degrees);
    if (!read) return false;
    const Status valid = validate(out);
    return valid || fail(valid.message());
  }

  void cameras(const Json& list, SceneDescription& scene) {
    where_ = "cameras";
    if (!list.is_array()) return void(fail("must be a list in brackets"));
    for (const Json& object : list) {
      where_ = "camera " + std::to_string(scene.cameras.size() + 1);
      if (!camera(object, scene.cameras.emplace_back())) return;
    }
  }

  void light(const Json& object, SceneDescription& scene) {
    if (!check_keys(object, {"center", "half_u", "half_v", "corner", "edge_u", "edge_v", "point"})) return;
    LightDescription result;
    const int forms = object.contains("center") + object.contains("corner") + object.contains("point");
    if (forms != 1) return void(fail("needs one of center, corner and point"));

    const bool corner = object.contains("corner"), point = object.contains("point");
    if (object.size() != (point ? 1u : 3u))
      return void(fail("center goes with half_u and half_v, corner with edge_u and edge_v"));
    bool read = vector(object, corner ? "corner" : point ? "point" : "center", result.center, true);
    if (!point) {
      read = read && vector(object, corner ? "edge_u" : "half_u", result.half_u, true) &&
             vector(object, corner ? "edge_v" : "half_v", result.half_v, true);
    }
    if (!read) return;
    if (corner) {
      result.half_u = 0.5f * result.half_u, result.half_v = 0.5f * result.half_v;
      result.center = result.center + result.half_u + result.half_v;
    }
    scene.light = result;
  }

  // `count` finite numbers in brackets.
  bool numbers(const Json& object, const char* key, std::span<float> out) {
    const Json& values = object[key];
    bool good = values.is_array() && values.size() == out.size();
    for (std::size_t i = 0; good && i < out.size(); ++i) {
      good = values[i].is_number();
      if (good) out[i] = values[i].get<float>(), good = std::isfinite(out[i]);
    }
    return good || fail(std::string(key) + " must be " + std::to_string(out.size()) + " numbers in brackets");
  }

  bool scale(const Json& object, float (&out)[3]) {
    if (!object.contains("scale")) return true;
    if (!object["scale"].is_number()) return numbers(object, "scale", out);
    out[0] = out[1] = out[2] = object["scale"].get<float>();
    return std::isfinite(out[0]) || fail("scale must be a number that floats can hold");
  }

  bool placement(const Json& object, Affine& out) {
    const bool parts = object.contains("scale") || object.contains("rotate") || object.contains("translate");
    if (object.contains("transform")) {
      if (parts) return fail("transform goes without scale, rotate and translate");
      return numbers(object, "transform", {&out.m[0][0], 12});
    }
    float scales[3] = {1, 1, 1}, turn[4] = {0, 1, 0, 0}, shift[3] = {0, 0, 0};
    if (!scale(object, scales)) return false;
    if (object.contains("rotate") && !numbers(object, "rotate", turn)) return false;
    if (object.contains("translate") && !numbers(object, "translate", shift)) return false;
    if (turn[0] == 0 && turn[1] == 0 && turn[2] == 0) return fail("rotate needs an axis that is not zero");
    out = placed_by({scales[0], scales[1], scales[2]}, {turn[0], turn[1], turn[2]}, turn[3], {shift[0], shift[1], shift[2]});
    return true;
  }

  void instances(const Json& list, SceneDescription& scene) {
    where_ = "instances";
    if (!list.is_array()) return void(fail("must be a list in brackets"));
    scene.instances.emplace();
    for (const Json& object : list) {
      where_ = "instance " + std::to_string(scene.instances->size() + 1);
      InstanceDescription& instance = scene.instances->emplace_back();
      if (!check_keys(object, {"mesh", "transform", "scale", "rotate", "translate"})) return;
      if (object.contains("mesh")) {
        if (!object["mesh"].is_string()) return void(fail("mesh must be the name of a file"));
        instance.mesh = object["mesh"].get<std::string>();
      }
      if (!placement(object, instance.transform)) return;
      if (const auto inverted = inverse(instance.transform); !inverted)
        return void(fail("its transform " + inverted.message()));
    }
  }

  const std::string& name_;
  std::string where_;
  std::string message_;
};

std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t end = 0; end != std::string_view::npos; line.remove_prefix(std::min(line.size(), end + 1))) {
    end = line.find(separator);
    parts.push_back(line.substr(0, end));
    if (end == std::string_view::npos) break;
  }
  return parts;
}

// One number for each of `out`, between blanks.
bool numbers(std::string_view text, std::span<float> out) {
  for (float& value : out) {
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (status != std::errc()) return false;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
  return text.find_first_not_of(' ') == std::string_view::npos;
}

// The columns of a table that describe a camera.
constexpr std::array<std::string_view, 6> kColumns = {"name", "file", "eye", "at", "up", "vfov_deg"};

bool read_row(const std::array<std::string_view, 6>& cells, CameraDescription& camera) {
  camera.name = cells[0];
  float eye[3], at[3], up[3], vfov[1];
  if (!numbers(cells[2], eye) || !numbers(cells[3], at) || !numbers(cells[4], up) || !numbers(cells[5], vfov)) return false;
  camera.eye = {eye[0], eye[1], eye[2]};
  camera.at = {at[0], at[1], at[2]};
  camera.up = {up[0], up[1], up[2]};
  camera.vfov_degrees = vfov[0];
  return true;
}

// Where each of kColumns stands in the header line; the message of the error names the one that is missing.
Result<std::array<std::size_t, 6>> find_columns(std::string_view header, const std::string& name) {
  if (!header.starts_with('#')) return Error{name + ":1: the header line must begin with #"};
  const std::vector<std::string_view> titles = split(header.substr(1), '\t');
  std::array<std::size_t, 6> columns;
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const auto found = std::find(titles.begin(), titles.end(), kColumns[i]);
    if (found == titles.end()) return Error{name + ":1: the column '" + std::string(kColumns[i]) + "' is missing"};
    columns[i] = static_cast<std::size_t>(found - titles.begin());
  }
  return columns;
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored) && !fs::is_directory(path, ignored);
}

}  // namespace

std::vector<fs::path> scene_description_names(const fs::path& scene) {
  const fs::path inner = is_zstd_name(scene) ? fs::path(scene).replace_extension() : scene;
  fs::path with_ending = scene;
  with_ending += ".json";
  return {with_ending, fs::path(inner).replace_extension(".json")};
}

Status validate(const CameraDescription& camera) try {
  if (!is_finite(camera.eye) || !is_finite(camera.at) || !is_finite(camera.up)) return Error{"eye, at and up must be finite"};
  if (camera.eye == camera.at) return Error{"eye and at are the same point"};
  // In double precision, where neither the difference nor the products overflow.
  const double d[3] = {double(camera.at.x) - camera.eye.x, double(camera.at.y) - camera.eye.y,
                       double(camera.at.z) - camera.eye.z};
  const double u[3] = {camera.up.x, camera.up.y, camera.up.z};
  double across = 0;
  for (int k = 0; k < 3; ++k)
    across = std::max(across, std::abs(d[(k + 1) % 3] * u[(k + 2) % 3] - d[(k + 2) % 3] * u[(k + 1) % 3]));
  if (!(across > 0)) return Error{"up is zero or lies along the view direction"};
  if (!(camera.vfov_degrees > 0 && camera.vfov_degrees < 180)) return Error{"vfov must lie between 0 and 180 degrees"};
  return Done{};
} catch (const std::bad_alloc&) {
  return out_of_memory("checking a camera");
}

Result<SceneDescription> parse_scene_json(std::string_view text, const std::string& name) try {
  return JsonReader(name).read(text);
} catch (const std::bad_alloc&) {
  return out_of_memory("reading a scene description");
}

Result<SceneDescription> parse_scene_table(std::string_view text, const std::string& name, std::string_view scene_file) try {
  SceneDescription scene;
  std::optional<std::array<std::size_t, 6>> columns;
  std::size_t line_number = 0;
  for (std::string_view line : split(text, '\n')) {
    ++line_number;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!columns) {
      const auto found = find_columns(line, name);
      if (!found) return found.error();
      columns = *found;
      continue;
    }
    if (line.empty() || line.starts_with('#')) continue;

    const std::vector<std::string_view> row = split(line, '\t');
    const auto error = [&](const std::string& what) { return Error{name + ":" + std::to_string(line_number) + ": " + what}; };
    if (row.size() <= *std::max_element(columns->begin(), columns->end())) return error("has too few columns");
    std::array<std::string_view, 6> cells;
    for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = row[(*columns)[i]];
    if (cells[1] != scene_file) continue;

    CameraDescription camera;
    if (!read_row(cells, camera)) return error("eye, at and up must be three numbers, vfov_deg one");
    if (const Status valid = validate(camera); !valid) return error(valid.message());
    scene.cameras.push_back(std::move(camera));
  }
  return scene;
} catch (const std::bad_alloc&) {
  return out_of_memory("reading a scene description");
}

Result<SceneDescription> find_scene_description(const fs::path& scene) try {
  const auto parsed = [](const fs::path& path, const auto& parse) -> Result<SceneDescription> {
    const Result<InputBytes> input = read_input(path);
    if (!input) return input.error();
    Result<SceneDescription> description = parse(input->text(), path.string());
    if (description) description->source = path;
    return description;
  };
  for (const fs::path& path : scene_description_names(scene))
    if (is_file(path)) return parsed(path, parse_scene_json);

  const fs::path table = scene.parent_path() / "scenes.tsv";
  if (!is_file(table)) return SceneDescription{};
  const std::string file = scene.filename().string();
  Result<SceneDescription> rows =
      parsed(table, [&](std::string_view text, const std::string& name) { return parse_scene_table(text, name, file); });
  if (rows && rows->cameras.empty()) return SceneDescription{};
  return rows;
} catch (const std::bad_alloc&) {
  return out_of_memory("reading a scene description");
}

}  // namespace accel
