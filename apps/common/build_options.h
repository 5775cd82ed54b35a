// The command line of accel-build.
#pragma once

#include <string>

#include "apps/common/common_settings.h"
#include "libaccel/build/builder.h"

namespace accel::apps {

struct BuildSettings {
  CommonSettings common;
  std::string help;  // what --help or --version asked for; then nothing else is set
  bool list = false;

  std::string scene;
  std::string output;  // empty: only report
  std::string method;  // that the structure is for: the one that was asked for, or the builder's first; empty: the best
  BuildOptions build;
  bool stats = false;    // histograms, and what is expensive to compute
  bool explain = false;  // what the build left out, and why
  std::string json;      // empty: none; "-": standard output
};

// That of a method's structure.
std::string builder_of(const std::string& method);

// Errors are usage errors; names of structures and methods are looked up here.
Outcome<BuildSettings> parse_build_options(int argc, char** argv);

}  // namespace accel::apps
