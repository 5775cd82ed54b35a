// A run of accel-trace, from settings to a report.
#pragma once

#include "apps/common/progress_bar.h"
#include "apps/common/terminal.h"
#include "apps/common/trace_options.h"
#include "apps/common/trace_report.h"

namespace accel::apps {

// Opens the scene, builds what is needed, traces, checks, and writes the files that the settings ask for. Wrong hits are no
// failure here: the report tells.
Outcome<TraceReport> run_trace(const TraceSettings& settings, const Terminal& terminal, ProgressBar& bar);

}  // namespace accel::apps
