// What a run of accel-trace found out, for the tables and for JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/common/embree_modes.h"
#include "apps/common/measure.h"
#include "apps/common/report_pictures.h"
#include "apps/common/scene.h"
#include "apps/common/sorted_rays.h"
#include "apps/common/structure_facts.h"
#include "apps/common/terminal.h"
#include "apps/common/trace_options.h"
#include "libaccel/exec/counters.h"
#include "libaccel/exec/multipass_profile.h"
#include "libaccel/exec/simt_profile.h"
#include "validation/compare/compare.h"

namespace accel::apps {

// Something that was left out, and why.
struct Skip {
  std::string what, why;
};

// A structure that was built, or the witness's.
struct StructureRow {
  std::string name;
  double build_seconds = 0;  // 0: read from a file
  std::uint64_t bytes = 0;
  BuildReport report;
  StructureFacts facts;
};

// Where a row of a sweep stands among those of its kind of rays (apps/common/sweep.h).
struct SweepPoint {
  double ns_per_ray = 0;               // the median
  validation::Rate error;              // wrong hits: the higher of the rates of these rays and of edge rays
  validation::Rate edge_error, leaks;  // of edge rays: wrong hits, and those that are misses
  bool on_front = false;               // no other is as fast and as good, and better in one of both
};

// A method or Embree in one of its modes, and a kind of rays.
struct TraceRow {
  std::string method, rays_kind;
  std::uint64_t rays = 0;
  Speed speed;
  std::vector<Measurement::Pass> passes;
  std::size_t structure = 0;                     // its row among the structures
  std::optional<Counters> counters;              // not for Embree
  std::optional<validation::CheckResult> check;  // not for Embree, and not when nothing is checked
  std::optional<SimtProfile> simt;
  std::optional<MultipassProfile> multipass;
  std::string repro;                        // the bundle that reproduces failures, where one was written
  const EmbreeTimed* embree = nullptr;      // the mode, of Embree's rows
  std::string test = {};                    // the triangle test, of ours
  bool promised = true;                     // wrong hits are failures: not of what is there to be compared
  std::optional<double> instructions = {};  // a ray, where they are counted
  std::optional<SweepPoint> point = {};     // of a sweep
  Query query = Query::closest;             // asked of the rays

  // "sbvh/stack", or with a test that is not the first, "sbvh/stack + woop".
  std::string configuration() const;
};

// A method, or Embree, in the built-in scene of another size: see apps/common/scaling.h.
struct ScalingPoint {
  std::string method, rays_kind;
  std::uint64_t triangles = 0;
  double ns_per_ray = 0, build_seconds = 0;
  std::uint64_t bytes = 0;
};

// What a sweep recommends for a kind of rays.
struct Advice {
  std::string rays_kind, text;
};

// A method on the rays of a kind in sorted order, beside the same in the order in which they came.
struct SortRow {
  std::string method, rays_kind;
  std::uint64_t rays = 0;
  std::size_t chunks = 0;  // RayOrder::chunks
  SortCost cost;
  Speed as_they_came, sorted;   // without the cost
  std::uint64_t different = 0;  // answers
  Query query = Query::closest;

  double sorted_in_all() const;  // millions of rays a second, the cost included
};

struct TraceReport {
  std::string scene;
  std::uint64_t triangles = 0;
  MeshFacts facts;
  double load_seconds = 0;
  CameraDescription camera;
  int threads = 0;         // that were used
  std::string device;      // "cpu", or the CUDA device's name
  std::string witness;     // "Embree 3.13.5 (avx2)", or empty
  std::string checked_by;  // what --check amounts to, in words
  std::vector<StructureRow> structures;
  std::vector<TraceRow> rows;  // by kind of rays, Embree last
  std::vector<SortRow> sorts;
  std::vector<BuildNote> notes;  // of the builds, each once
  std::vector<Skip> skipped;
  std::vector<Advice> advice;            // of a sweep, by kind of rays
  std::vector<ScalingPoint> scaling;     // by method, and by triangles
  std::vector<MethodPictures> pictures;  // for --report

  std::uint64_t failures() const;
  // Embree's rows for a kind of rays: the one that ratios refer to, or null; its fastest mode, where several were timed, or
  // null; and all of them.
  const TraceRow* embree_row(const std::string& rays_kind) const;
  const TraceRow* best_embree_row(const std::string& rays_kind) const;
  std::vector<const TraceRow*> embree_rows(const std::string& rays_kind) const;
};

// The tables: failures first, if there are any. 100 columns at most.
std::string report_text(const TraceReport& report, const TraceSettings& settings, const Terminal& terminal);

// Google Benchmark's shape: "context" and "benchmarks".
std::string report_json(const TraceReport& report, const TraceSettings& settings);

}  // namespace accel::apps
