// A run of accel-build, and its report.
#pragma once

#include <string>

#include "apps/common/build_options.h"
#include "apps/common/progress_bar.h"
#include "apps/common/scene.h"
#include "apps/common/structure_facts.h"
#include "apps/common/terminal.h"

namespace accel::apps {

struct BuildRunReport {
  std::string scene, builder, structure;
  std::uint64_t triangles = 0, skipped_faces = 0, mesh_bytes = 0, bytes = 0;
  double load_seconds = 0;
  int threads = 0;
  BuildReport build;
  StructureFacts facts;
  std::string output;  // the file that was written, if any
};

// Opens the scene, builds the structure, and writes the file that the settings ask for.
Outcome<BuildRunReport> run_build(const BuildSettings& settings, ProgressBar& bar);

std::string build_report_text(const BuildRunReport& report, const BuildSettings& settings, const Terminal& terminal);
std::string build_report_json(const BuildRunReport& report, const BuildSettings& settings);

}  // namespace accel::apps
