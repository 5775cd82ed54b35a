// accel-trace --scaling: how the time of a ray, of a build and the memory of a structure grow with a scene.
//
// Traversal should cost no more than c log n and, where a structure outgrows a cache, a step; builds n log n. The curves show
// whether they do: the methods of a run and Embree, on the first kind of rays, in the built-in scene of several sizes.
#pragma once

#include <string>

#include "apps/common/trace_options.h"
#include "apps/common/trace_report.h"

namespace accel::apps {

// "builtin:soup:1k" for builtin:soup and 1k.
std::string scene_of_size(const std::string& scene, const std::string& size);

// The settings of a run in the scene of another size, whose rows are all that is of interest: nothing is checked or written.
TraceSettings settings_for_size(const TraceSettings& settings, const std::string& size);

// Adds a run's rows as points.
void add_points(const TraceReport& run, std::vector<ScalingPoint>& points);

std::string scaling_section(const TraceReport& report, const Terminal& terminal);

}  // namespace accel::apps
