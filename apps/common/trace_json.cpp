// report_json() of trace_report.h.
#include <unistd.h>

#include <chrono>
#include <ctime>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/common/text.h"
#include "apps/common/trace_report.h"
#include "apps/common/versions.h"
#include "libaccel/registry/any_accel.h"

namespace accel::apps {

namespace {

using Json = nlohmann::ordered_json;
using validation::Verdicts;

std::string host_name() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "";
}

std::string date_text() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm local{};
  char text[64];
  const std::size_t length = std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S%z", localtime_r(&now, &local));
  return {text, length};
}

// As --query has it.
const char* query_text(Query query) { return query == Query::any ? "any" : "closest"; }

Json vec_json(Vec3 v) { return {v.x, v.y, v.z}; }

Json camera_json(const CameraDescription& c) {
  return {{"name", c.name}, {"eye", vec_json(c.eye)}, {"at", vec_json(c.at)}, {"up", vec_json(c.up)}, {"vfov", c.vfov_degrees}};
}

// What is known of a structure's leaves and its quality.
void add_facts(Json& json, const StructureFacts& facts) {
  if (facts.sah_cost) json["sah_cost"] = *facts.sah_cost;
  if (facts.depth) json["depth"] = *facts.depth;
  if (facts.inner_nodes) json["inner_nodes"] = *facts.inner_nodes;
  if (facts.leaves) json["leaves"] = *facts.leaves;
  if (facts.leaf_size_mean) json["leaf_size_mean"] = *facts.leaf_size_mean;
  if (!facts.leaf_sizes.empty()) json["leaf_sizes"] = facts.leaf_sizes;
  if (!facts.leaf_depths.empty()) json["leaf_depths"] = facts.leaf_depths;
}

Json structure_json(const StructureRow& row) {
  Json json = {{"name", row.name}};
  if (row.build_seconds > 0) json["build_seconds"] = row.build_seconds;
  json["bytes"] = row.bytes;
  if (row.report.references == 0) return json;
  json["triangles"] = row.report.triangles;
  json["references"] = row.report.references;
  json["skipped"] = {{"zero_area", row.report.skipped.zero_area}, {"out_of_range", row.report.skipped.out_of_range}};
  json["peak_bytes"] = row.report.peak_bytes;
  for (const BuildPhase& phase : row.report.phases) json["phases"][phase.name] = phase.seconds;
  add_facts(json, row.facts);
  return json;
}

// Of all rows: those of sweeps have their own.
std::string triangle_test_text(const TraceSettings& settings) {
  if (!settings.test.empty()) return settings.test;
  return settings.sweep ? "all" : triangle_tests().front();
}

Json context_json(const TraceReport& report, const TraceSettings& settings) {
  Json versions_json;
  for (const auto& [name, version] : versions()) versions_json[name] = version;
  Json skipped = Json::array();
  for (const Skip& skip : report.skipped) skipped.push_back({{"what", skip.what}, {"because", skip.why}});
  Json notes = Json::array();
  for (const BuildNote& note : report.notes) notes.push_back({{"what", note.what}, {"why", note.why}});
  Json structures = Json::array();
  for (const StructureRow& row : report.structures) structures.push_back(structure_json(row));
  return {{"date", date_text()},
          {"host_name", host_name()},
          {"executable", "accel-trace"},
          {"command_line", settings.common.command_line},
          {"num_cpus", std::thread::hardware_concurrency()},
          {"library_build_type", ACCEL_BUILD_TYPE},
          {"versions", versions_json},
          {"threads", report.threads},
          {"seed", settings.common.seed},
          {"repeat", settings.repeat},
          {"scene", report.scene},
          {"triangles", report.triangles},
          {"load_seconds", report.load_seconds},
          {"camera", camera_json(report.camera)},
          {"width", settings.width},
          {"height", settings.height},
          {"spp", settings.spp},
          {"pixel_order", order_name(settings.pixel_order)},
          {"query", settings.query ? query_text(*settings.query) : ""},
          {"device", report.device},
          {"triangle_test", triangle_test_text(settings)},
          {"packets",
           {{"max_size", settings.packets.max_size},
            {"block_size", settings.packets.block_size},
            {"cell_fraction", settings.packets.cell_fraction}}},
          {"check", report.checked_by},
          {"witness", report.witness},
          {"structures", structures},
          {"notes", notes},
          {"skipped", skipped}};
}

Json verdicts_json(const Verdicts& v) {
  return {{"agree", v.agree}, {"judged", v.judged}, {"right", v.right}, {"neighbour", v.neighbour},
          {"edge", v.edge},   {"miss", v.miss},     {"far", v.far},     {"false", v.false_hit}};
}

void add_check(Json& json, const validation::CheckResult& check) {
  const auto add_rate = [&](const std::string& name, const Verdicts& verdicts) {
    const validation::Rate wrong = check.rate_of(verdicts.failures());
    json[name] = wrong.per_million, json[name + "_bound95"] = wrong.bound95_per_million;  // NaN is null
  };
  json["verdicts"] = verdicts_json(check.ours);
  json["unjudged"] = check.unjudged;
  if (check.has_witness) {
    const auto& a = check.adjudication;
    json["embree_verdicts"] = verdicts_json(check.witness);
    json["adjudication"] = {{"both_right", a.both_right},
                            {"only_ours_right", a.only_ours_right},
                            {"only_embree_right", a.only_witness_right},
                            {"both_wrong", a.both_wrong}};
    add_rate("embree_wrong_per_million", check.witness);
  }
  add_rate("wrong_per_million", check.ours);
  const auto& e = check.errors;
  if (e.samples > 0) {
    json["t_ulp"] = {{"mean", e.t_ulp_mean}, {"p50", e.t_ulp_p50}, {"p99", e.t_ulp_p99}, {"max", e.t_ulp_max}};
    json["barycentric_error_max"] = e.barycentric_max;
  }
}

void add_counters(Json& json, const Counters& counters, std::uint64_t rays) {
  const double n = rays == 0 ? 1.0 : static_cast<double>(rays);
  const auto per_ray = [&](std::uint64_t sum) { return static_cast<double>(sum) / n; };
  json["nodes_per_ray"] = per_ray(counters.node_steps);
  json["box_tests_per_ray"] = per_ray(counters.box_tests);
  json["triangle_tests_per_ray"] = per_ray(counters.triangle_tests);
  json["leaves_per_ray"] = per_ray(counters.leaf_visits);
  json["backtracks_per_ray"] = per_ray(counters.backtracks);
  std::uint64_t bytes = 0;
  for (const std::uint64_t b : counters.bytes) bytes += b;
  json["bytes_per_ray"] = per_ray(bytes);
}

Json phase_json(const SimtProfile::PhaseSteps& phase) {
  return {{"steps", phase.steps}, {"active_lanes", phase.active_lanes}, {"efficiency", phase.efficiency()}};
}

Json simt_json(const SimtProfile& profile) {
  constexpr const char* kNames[kMemoryClasses] = {"node", "triangle", "stack", "hash", "ray"};
  Json json = {{"warps", profile.warps},
               {"efficiency", profile.efficiency()},
               {"descend", phase_json(profile.descend)},
               {"intersect", phase_json(profile.intersect)},
               {"backtrack", phase_json(profile.backtrack)}};
  for (int c = 0; c < kMemoryClasses; ++c) {
    const SimtProfile::Traffic& t = profile.traffic[c];
    json["traffic"][kNames[c]] = {{"requests", t.requests}, {"lines", t.lines}, {"sectors", t.sectors}, {"bytes", t.bytes}};
  }
  return json;
}

Json multipass_json(const MultipassProfile& profile, const MultipassOptions& options) {
  const MultipassProfile::KernelPasses all = profile.total();
  Json json = {{"rule", rule_name(options.rule)},
               {"compact", options.compact},
               {"batch_size", options.batch_size},
               {"batches", profile.batches},
               {"passes", all.passes},
               {"switches", profile.switches},
               {"utilisation", all.utilisation()},
               {"warp_utilisation", all.warp_utilisation()},
               {"transitions", profile.transitions()},
               {"bytes_recirculated", all.bytes_recirculated()},
               {"bytes_fetched", all.bytes_fetched},
               {"bytes_in_flight", profile.bytes_in_flight}};
  for (int k = 0; k < kMultipassKernels; ++k) {
    const MultipassProfile::KernelPasses& p = profile.kernels[static_cast<std::size_t>(k)];
    json["kernels"][kernel_name(static_cast<MultipassKernel>(k))] = {{"passes", p.passes},
                                                                     {"rays", p.rays},
                                                                     {"utilisation", p.utilisation()},
                                                                     {"warp_utilisation", p.warp_utilisation()},
                                                                     {"bytes_read", p.bytes_read},
                                                                     {"bytes_written", p.bytes_written},
                                                                     {"bytes_fetched", p.bytes_fetched},
                                                                     {"bytes_schedule", p.bytes_schedule}};
  }
  return json;
}

// How a row compares with Embree, and where several of its modes were timed, with each.
void add_embree(Json& json, const TraceRow& row, const TraceReport& report) {
  const auto ratio_to = [&](const TraceRow& embree) { return row.speed.median / embree.speed.median; };
  const TraceRow* const embree = report.embree_row(row.rays_kind);
  if (embree == nullptr || !(embree->speed.median > 0)) return;
  json["embree_mrays_per_second"] = embree->speed.median;
  json["ratio_to_embree"] = ratio_to(*embree);
  const TraceRow* const best = report.best_embree_row(row.rays_kind);
  if (best == nullptr) return;
  json["best_embree_mode"] = best->embree->name;
  json["ratio_to_best_embree"] = ratio_to(*best);
  for (const TraceRow* mode : report.embree_rows(row.rays_kind))
    json["embree_modes"].push_back({{"name", mode->embree->name},
                                    {"mrays_per_second", mode->speed.median},
                                    {"mrays_min", mode->speed.least},
                                    {"mrays_max", mode->speed.most},
                                    {"ratio", ratio_to(*mode)}});
}

// Where a row stands in a sweep.
void add_point(Json& json, const SweepPoint& point) {
  const auto rate = [](const validation::Rate& r) {
    return Json{{"per_million", r.per_million}, {"bound95_per_million", r.bound95_per_million}};
  };
  json["error"] = rate(point.error);
  json["edge_error"] = rate(point.edge_error);
  json["leaks"] = rate(point.leaks);
  json["pareto"] = point.on_front;
}

Json row_json(const TraceRow& row, const TraceReport& report, const TraceSettings& settings) {
  Measurement::Pass mean;
  for (const Measurement::Pass& pass : row.passes) {
    mean.seconds += pass.seconds / static_cast<double>(row.passes.size());
    mean.cpu_seconds += pass.cpu_seconds / static_cast<double>(row.passes.size());
  }
  const bool is_first_test = row.configuration() == row.method;
  const std::string name = report.scene + "/" + row.method + "/" + row.rays_kind + (is_first_test ? "" : "/" + row.test);
  Json json = {{"name", name},
               {"run_name", name},
               {"run_type", "iteration"},
               {"repetitions", 1},
               {"threads", report.threads},
               {"iterations", row.passes.size()},
               {"real_time", 1e3 * mean.seconds},
               {"cpu_time", 1e3 * mean.cpu_seconds},
               {"time_unit", "ms"},
               {"method", row.method},
               {"rays_kind", row.rays_kind},
               {"query", query_text(row.query)},
               {"rays", row.rays},
               {"mrays_per_second", row.speed.median},
               {"mrays_min", row.speed.least},
               {"mrays_max", row.speed.most}};
  if (!row.test.empty()) json["test"] = row.test;
  if (row.speed.median > 0) json["ns_per_ray"] = 1e3 / row.speed.median;
  if (row.instructions) json["instructions_per_ray"] = *row.instructions;
  json["promised"] = row.promised;
  if (row.point) add_point(json, *row.point);
  add_embree(json, row, report);
  if (row.check) add_check(json, *row.check);
  const StructureRow& structure = report.structures[row.structure];
  json["structure"] = structure.name;
  if (structure.build_seconds > 0) json["build_seconds"] = structure.build_seconds;
  json["bytes"] = structure.bytes;
  if (report.triangles > 0)
    json["bytes_per_triangle"] = static_cast<double>(structure.bytes) / static_cast<double>(report.triangles);
  if (structure.facts.sah_cost) json["sah_cost"] = *structure.facts.sah_cost;
  if (structure.facts.depth) json["depth"] = *structure.facts.depth;
  if (row.counters) add_counters(json, *row.counters, row.rays);
  if (row.simt) json["simt"] = simt_json(*row.simt);
  if (row.multipass) json["multipass"] = multipass_json(*row.multipass, settings.multipass);
  return json;
}

Json sort_json(const SortRow& row, const TraceReport& report, const TraceSettings& settings) {
  return {{"name", report.scene + "/" + row.method + "/" + row.rays_kind + "/" + name_of(*settings.sort)},
          {"run_type", "iteration"},
          {"threads", report.threads},
          {"method", row.method},
          {"rays_kind", row.rays_kind},
          {"query", query_text(row.query)},
          {"rays", row.rays},
          {"sort", name_of(*settings.sort)},
          {"cell_fraction", settings.packets.cell_fraction},
          {"chunks", row.chunks},
          {"hash_ms", 1e3 * row.cost.hash},
          {"sort_ms", 1e3 * row.cost.sort},
          {"copy_ms", 1e3 * row.cost.copy},
          {"mrays_per_second", row.sorted_in_all()},
          {"mrays_without_sort_cost", row.sorted.median},
          {"mrays_as_they_came", row.as_they_came.median},
          {"different_answers", row.different}};
}

}  // namespace

std::string report_json(const TraceReport& report, const TraceSettings& settings) {
  Json json = {{"context", context_json(report, settings)}, {"benchmarks", Json::array()}};
  for (const TraceRow& row : report.rows) json["benchmarks"].push_back(row_json(row, report, settings));
  for (const SortRow& row : report.sorts) json["benchmarks"].push_back(sort_json(row, report, settings));
  for (const ScalingPoint& point : report.scaling)
    json["scaling"].push_back({{"method", point.method},
                               {"rays_kind", point.rays_kind},
                               {"triangles", point.triangles},
                               {"ns_per_ray", point.ns_per_ray},
                               {"build_seconds", point.build_seconds},
                               {"bytes", point.bytes}});
  for (const Advice& advice : report.advice) json["context"]["advice"][advice.rays_kind] = advice.text;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace accel::apps
