// What `accel-trace stress` prints.
#pragma once

#include <string>

#include "apps/common/stress_run.h"
#include "apps/common/terminal.h"

namespace accel::apps {

// The catalogue, with what is expected of each case.
std::string stress_listing();

// A row for each case and method; methods that have nothing wrong share one, unless the terminal is verbose. Embree's rows are
// measured by the same bounds, and nothing is expected of them.
std::string stress_text(const StressReport& report, const StressSettings& settings, const Terminal& terminal);

std::string stress_json(const StressReport& report, const StressSettings& settings);

}  // namespace accel::apps
