// The reports of build_run.h.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/common/build_run.h"
#include "apps/common/table.h"
#include "apps/common/text.h"
#include "apps/common/versions.h"

namespace accel::apps {

namespace {

using Align = Table::Align;

// At most this many bars; longer histograms are put into groups of equal width.
constexpr std::size_t kMostBars = 16;
constexpr double kBarColumns = 50;

// One bar a value (or group of values), as long as its share of the largest.
std::string histogram_text(const std::vector<std::uint64_t>& counts, const std::string& title, const Terminal& terminal) {
  if (counts.empty()) return {};
  const std::size_t group = (counts.size() + kMostBars - 1) / kMostBars;
  Table table({{title}, {"count"}, {"", Align::left}});
  std::vector<std::uint64_t> sums((counts.size() + group - 1) / group, 0);
  for (std::size_t i = 0; i < counts.size(); ++i) sums[i / group] += counts[i];
  const double most = static_cast<double>(std::max<std::uint64_t>(*std::max_element(sums.begin(), sums.end()), 1));
  for (std::size_t g = 0; g < sums.size(); ++g) {
    const std::size_t first = g * group, last = std::min(first + group, counts.size()) - 1;
    const auto columns = static_cast<std::size_t>(static_cast<double>(sums[g]) / most * kBarColumns + 0.5);
    table.add_row({first == last ? std::to_string(first) : std::to_string(first) + " - " + std::to_string(last),
                   with_commas(sums[g]), terminal.styled(std::string(columns, '#'), Style::faint)});
  }
  return "\n" + table.text();
}

std::string phases_text(const BuildReport& build) {
  std::vector<std::string> parts;
  for (const BuildPhase& phase : build.phases) parts.push_back(phase.name + " " + seconds_text(phase.seconds));
  return parts.empty() ? "" : "  phases: " + join(parts, ", ") + "\n";
}

std::string left_out_text(std::uint64_t faces, const Skipped& skipped) {
  std::vector<std::string> parts;
  if (faces > 0) parts.push_back(counted(faces, "face") + ", because " + it_has(faces) + " fewer than three corners");
  if (skipped.zero_area > 0)
    parts.push_back(counted(skipped.zero_area, "triangle") + ", because " + it_has(skipped.zero_area) + " no area");
  if (skipped.out_of_range > 0)
    parts.push_back(counted(skipped.out_of_range, "triangle") + ", because " + it_has(skipped.out_of_range) +
                    " a coordinate that is not finite or too large");
  std::string text;
  for (const std::string& part : parts) text += "  skipped: " + part + "\n";
  return text;
}

std::string references_text(const BuildReport& build) {
  const double triangles = static_cast<double>(std::max<std::uint64_t>(build.triangles, 1));
  const double each = static_cast<double>(build.references) / triangles;
  return "  " + counted(build.references, "reference") + " to " + counted(build.triangles, "triangle") +
         (each < 2 ? print(" (duplication %.1f %%)", 100 * (each - 1)) : "") + "\n";
}

// One line on shape and quality, and for trees of cells one on what a random line meets.
std::string quality_text(const StructureFacts& facts) {
  std::vector<std::string> quality;
  if (facts.depth) quality.push_back(counted(static_cast<std::uint64_t>(*facts.depth), "level") + " deep");
  if (facts.resolution) quality.push_back(*facts.resolution + " cells");
  if (facts.sah_cost) quality.push_back("SAH cost " + short_number(*facts.sah_cost));
  if (facts.epo) quality.push_back("end-point overlap " + short_number(*facts.epo));
  if (facts.leaf_size_mean)
    quality.push_back(short_number(*facts.leaf_size_mean) + " triangles a leaf (variance " +
                      short_number(*facts.leaf_size_variance) + ")");
  std::vector<std::string> cells;
  if (facts.inner_nodes) cells.push_back(counted(*facts.inner_nodes, "inner node"));
  if (facts.leaves) cells.push_back(with_commas(*facts.leaves) + (*facts.leaves == 1 ? " leaf" : " leaves"));
  if (facts.empty_leaf_share) cells.push_back(print("%.1f %% of leaves empty", 100 * *facts.empty_leaf_share));
  if (facts.references_per_triangle) cells.push_back(short_number(*facts.references_per_triangle) + " references a triangle");
  std::string text = quality.empty() ? "" : "  " + join(quality, ", ") + "\n";
  if (!cells.empty()) text += "  " + join(cells, ", ") + "\n";
  if (facts.expected_steps)
    text += "  a random line expects " + short_number(*facts.expected_steps) + " steps and " +
            short_number(*facts.expected_tests) + " triangle tests\n";
  return text;
}

std::string notes_text(const std::vector<BuildNote>& notes) {
  std::string text;
  for (const BuildNote& note : notes) text += "  " + note.what + ": " + note.why + "\n";
  return text.empty() ? "  nothing was left out\n" : text;
}

std::string arrays_text(const StructureFacts& facts) {
  Table table({{"ARRAY", Align::left}, {"memory"}});
  for (const auto& [name, bytes] : facts.arrays) table.add_row({name, bytes_text(bytes)});
  return "\n" + table.text();
}

}  // namespace

std::string build_report_text(const BuildRunReport& r, const BuildSettings& settings, const Terminal& terminal) {
  std::string text = terminal.styled(r.scene, Style::strong) + "  " + counted(r.triangles, "triangle") + " in " +
                     bytes_text(r.mesh_bytes) + ", loaded in " + seconds_text(r.load_seconds) + "\n";
  text += terminal.styled(r.builder, Style::strong) + " (" + r.structure + ")  built in " + seconds_text(r.build.seconds) +
          " by " + counted(static_cast<std::uint64_t>(r.threads), "thread") + ": " + bytes_text(r.bytes);
  if (r.build.peak_bytes > 0) text += ", " + bytes_text(r.build.peak_bytes) + " while building";
  text += "\n" + phases_text(r.build);
  text += references_text(r.build) + quality_text(r.facts) + left_out_text(r.skipped_faces, r.build.skipped);
  if (settings.explain) text += notes_text(r.build.notes);
  if (settings.stats) {
    text += arrays_text(r.facts);
    text += histogram_text(r.facts.leaf_sizes, "LEAF SIZE", terminal);
    text += histogram_text(r.facts.leaf_depths, "LEAF DEPTH", terminal);
  }
  if (!r.output.empty()) text += "written to " + r.output + "\n";
  return text;
}

std::string build_report_json(const BuildRunReport& r, const BuildSettings& settings) {
  using Json = nlohmann::ordered_json;
  Json versions_json;
  for (const auto& [name, version] : versions()) versions_json[name] = version;
  Json row = {{"name", r.scene + "/" + r.builder},
              {"run_name", r.scene + "/" + r.builder},
              {"run_type", "iteration"},
              {"iterations", 1},
              {"real_time", 1e3 * r.build.seconds},
              {"time_unit", "ms"},
              {"structure", r.structure},
              {"builder", r.builder},
              {"build_seconds", r.build.seconds},
              {"bytes", r.bytes},
              {"peak_bytes", r.build.peak_bytes},
              {"triangles", r.build.triangles},
              {"references", r.build.references},
              {"skipped", {{"zero_area", r.build.skipped.zero_area}, {"out_of_range", r.build.skipped.out_of_range}}}};
  row["skipped"]["faces"] = r.skipped_faces;
  for (const BuildPhase& phase : r.build.phases) row["phases"][phase.name] = phase.seconds;
  if (r.facts.depth) row["depth"] = *r.facts.depth;
  if (r.facts.resolution) row["resolution"] = *r.facts.resolution;
  if (r.facts.empty_leaf_share) row["empty_leaf_share"] = *r.facts.empty_leaf_share;
  if (r.facts.references_per_triangle) row["references_per_triangle"] = *r.facts.references_per_triangle;
  if (r.facts.sah_cost) row["sah_cost"] = *r.facts.sah_cost;
  if (r.facts.epo) row["epo"] = *r.facts.epo;
  if (r.facts.leaf_size_variance) row["leaf_size_variance"] = *r.facts.leaf_size_variance;
  if (r.facts.inner_nodes) row["inner_nodes"] = *r.facts.inner_nodes;
  if (r.facts.leaves) row["leaves"] = *r.facts.leaves;
  if (r.facts.leaf_size_mean) row["leaf_size_mean"] = *r.facts.leaf_size_mean;
  if (r.facts.expected_steps) row["expected_steps"] = *r.facts.expected_steps;
  if (r.facts.expected_tests) row["expected_tests"] = *r.facts.expected_tests;
  for (const auto& [name, bytes] : r.facts.arrays) row["array_bytes"][name] = bytes;
  row["notes"] = Json::array();
  for (const BuildNote& note : r.build.notes) row["notes"].push_back({{"what", note.what}, {"why", note.why}});
  if (!r.facts.leaf_sizes.empty()) row["leaf_sizes"] = r.facts.leaf_sizes;
  if (!r.facts.leaf_depths.empty()) row["leaf_depths"] = r.facts.leaf_depths;
  const Json context = {{"executable", "accel-build"},    {"command_line", settings.common.command_line},
                        {"versions", versions_json},      {"scene", r.scene},
                        {"load_seconds", r.load_seconds}, {"threads", r.threads},
                        {"seed", settings.common.seed},   {"output", r.output}};
  return Json{{"context", context}, {"benchmarks", Json::array({row})}}.dump(2, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

}  // namespace accel::apps
