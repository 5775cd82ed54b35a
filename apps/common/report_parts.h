// The parts of a report's page that do not depend on a run: the files of apps/report, which CMake puts into the program.
#pragma once

#include <string_view>

namespace accel::apps::report_parts {

extern const std::string_view page, style, script;             // HTML, CSS, JavaScript
extern const std::string_view pareto, speed, leaves, scaling;  // Vega-Lite

}  // namespace accel::apps::report_parts
