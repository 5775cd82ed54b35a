// The command line of `accel-trace stress`.
#pragma once

#include <string>
#include <vector>

#include "apps/common/common_settings.h"
#include "validation/stress/catalogue.h"

namespace accel::apps {

struct StressSettings {
  CommonSettings common;
  std::string help;  // what --help or --version asked for; then nothing else is set
  bool list = false;

  std::vector<const validation::StressCase*> cases;
  std::vector<std::string> methods;
  std::uint64_t rays = 0;  // of each case and method; 0: as many as the hours allow
  double hours = 0;        // 0: until all rays are traced
  bool embree = true;      // beside ours, as the witness

  std::string resume, json;            // files; empty: none
  std::string repro = "accel-stress";  // how names of files that reproduce failures begin
};

// `argv[0]` is "stress". All errors are usage errors; names are looked up here.
Outcome<StressSettings> parse_stress_options(int argc, char** argv);

}  // namespace accel::apps
