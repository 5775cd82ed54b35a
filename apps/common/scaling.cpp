#include "apps/common/scaling.h"

#include <algorithm>

#include "apps/common/table.h"
#include "apps/common/text.h"

namespace accel::apps {

std::string scene_of_size(const std::string& scene, const std::string& size) {
  return scene.substr(0, scene.find(':', std::string("builtin:").size())) + ":" + size;
}

TraceSettings settings_for_size(const TraceSettings& settings, const std::string& size) {
  TraceSettings other = settings;
  other.scene = scene_of_size(settings.scene, size);
  other.ray_kinds.resize(1);
  other.embree = {"fast"};
  other.check = Check::none;
  other.scaling.clear();
  other.sweep = other.profile_simt = other.profile_multipass = false;
  other.sort.reset();
  other.image = other.heatmap = other.diff = other.rays_out = other.hits_out = other.report = "";
  other.hits = 0;
  return other;
}

void add_points(const TraceReport& run, std::vector<ScalingPoint>& points) {
  for (const TraceRow& row : run.rows) {
    if (!(row.speed.median > 0)) continue;
    const StructureRow& structure = run.structures[row.structure];
    points.push_back(
        {row.method, row.rays_kind, run.triangles, 1e3 / row.speed.median, structure.build_seconds, structure.bytes});
  }
  std::stable_sort(points.begin(), points.end(), [](const ScalingPoint& a, const ScalingPoint& b) {
    return a.method != b.method ? a.method < b.method : a.triangles < b.triangles;
  });
}

std::string scaling_section(const TraceReport& report, const Terminal& terminal) {
  Table table({{"METHOD", Table::Align::left}, {"triangles"}, {"ns/ray"}, {"build"}, {"ns/triangle"}, {"memory"}, {"B/tri"}});
  const std::string* method = nullptr;
  for (const ScalingPoint& point : report.scaling) {
    const auto triangles = static_cast<double>(std::max<std::uint64_t>(point.triangles, 1));
    table.add_row({method != nullptr && *method == point.method ? "" : point.method, with_commas(point.triangles),
                   short_number(point.ns_per_ray), seconds_text(point.build_seconds),
                   short_number(1e9 * point.build_seconds / triangles), bytes_text(point.bytes),
                   short_number(static_cast<double>(point.bytes) / triangles)});
    method = &point.method;
  }
  return "\n" + terminal.styled("Scaling, " + report.scaling.front().rays_kind + " rays", Style::strong) + "\n" + table.text();
}

}  // namespace accel::apps
