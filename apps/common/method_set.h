// The methods of a run, ready to trace. Methods that share a builder share the structure, and only what is needed is built.
#pragma once

#include <string>
#include <vector>

#include "apps/common/progress_bar.h"
#include "apps/common/scene.h"
#include "apps/common/trace_report.h"
#include "libaccel/registry/any_accel.h"

namespace accel::apps {

// With "all", exhaustive methods take part only up to this many triangle tests a pass: about a second's worth.
inline constexpr std::uint64_t kMostExhaustiveTests = 200'000'000;

struct MethodSet {
  struct Member {
    AnyAccel accel;
    std::size_t structure;  // its row among the structures
  };
  std::vector<Member> members;
  std::vector<StructureRow> structures;
};

// Resolves the names ("best", "all") for this scene, then builds or, for a structure file, binds what they need. Methods that
// do not fit a structure file are an error if named, and skipped with "all".
Outcome<MethodSet> prepare_methods(const Scene& scene, const TraceSettings& settings, ProgressBar& bar,
                                   std::vector<Skip>& skipped);

}  // namespace accel::apps
