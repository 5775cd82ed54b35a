#include "bench/paper_tables/paper_tables.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "libaccel/io/load_scene.h"
#include "libaccel/rays/camera.h"
#include "libaccel/rays/default_light.h"
#include "scenes/procedural.h"

namespace accel::paper_tables {

Result<LoadedScene> load(const PaperScene& scene, const Settings& settings) {
  const std::filesystem::path path = std::filesystem::path(settings.scenes) / (std::string(scene.file) + ".ply.zst");
  std::error_code error;
  const bool found = std::filesystem::exists(path, error);
  Result<SceneData> data = found ? load_scene(path) : make_builtin(scene.stand_in);
  if (!data) return data.error();
  Result<TriangleMesh> mesh = data->one_mesh();
  if (!mesh) return mesh.error();
  data->mesh = *std::move(mesh);
  return LoadedScene{std::move(data).value(), !found};
}

namespace {

Aabb bounds_of(const SceneData& scene) {
  Aabb bounds;
  for (const Vec3& v : scene.mesh.vertices)
    if (in_range(v)) bounds.extend(v);
  return bounds;
}

CameraDescription view_of(const SceneData& scene) {
  return scene.cameras.empty() ? default_camera(bounds_of(scene)) : scene.cameras.front();
}

}  // namespace

Result<RaySet> primary_rays(const SceneData& scene, std::uint32_t size, PixelOrder order) {
  const auto camera = Camera::make(view_of(scene), size, size);
  if (!camera) return camera.error();
  return accel::primary_rays(*camera, 1, 1, order);
}

LightDescription light_of(const SceneData& scene) {
  return scene.light.value_or(default_light(bounds_of(scene), view_of(scene)));
}

std::string title_of(const PaperScene& scene, bool is_stand_in) { return std::string(scene.title) + (is_stand_in ? " *" : ""); }

std::string heading(const std::string& text) { return "\n" + paragraph(text, 0, 2); }

std::string notes_title(bool has_stand_in) {
  const std::string title = "\nWhere and why they differ\n";
  if (!has_stand_in) return title;
  return title + paragraph(
                     "* A built-in scene of comparable kind stands in for the paper's, which was not found: no figure "
                     "compares.");
}

Json new_row(const std::string& paper, const PaperScene& scene, bool is_stand_in, const std::string& name) {
  return {{"name", paper + "/" + scene.file + "/" + name},
          {"run_type", "iteration"},
          {"scene", is_stand_in ? scene.stand_in : scene.file}};
}

std::uint64_t issued(const SimtProfile& p) { return p.descend.steps + p.intersect.steps + p.backtrack.steps; }

SimtProfile::Traffic all_traffic(const SimtProfile& p) {
  SimtProfile::Traffic all;
  for (const SimtProfile::Traffic& t : p.traffic) all += t;
  return all;
}

std::string TextTable::text() const {
  std::vector<std::size_t> width;
  for (const auto& row : rows_) {
    width.resize(std::max(width.size(), row.size()), 0);
    for (std::size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
  }
  std::string text;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string padding(width[c] - row[c].size(), ' ');
      line += "  " + (c == 0 ? row[c] + padding : padding + row[c]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string paragraph(const std::string& text, std::size_t first, std::size_t rest) {
  constexpr std::size_t kWidth = 100;
  std::string lines, line(first, ' ');
  bool is_empty = true;
  std::istringstream words(text);
  for (std::string word; words >> word; is_empty = false) {
    if (!is_empty && line.size() + 1 + word.size() > kWidth) {
      lines += line + "\n";
      line.assign(rest, ' ');
    } else if (!is_empty) {
      line += ' ';
    }
    line += word;
  }
  return lines + line + "\n";
}

std::string print(const char* format, ...) {
  va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, arguments);
  va_end(arguments);
  std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
  if (length > 0) std::vsnprintf(text.data(), text.size() + 1, format, again);
  va_end(again);
  return text;
}

std::string number(double value) {
  return value < 9.995 ? print("%.2f", value) : value < 99.95 ? print("%.1f", value) : print("%.0f", value);
}
std::string percent(double share) { return number(100 * share) + " %"; }

double mrays_of(std::size_t rays, double ms) { return 1e-3 * static_cast<double>(rays) / std::max(ms, 1e-6); }

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

}  // namespace accel::paper_tables
