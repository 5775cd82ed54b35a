// The report of a run as one page that opens offline (accel-trace --report): tables for all readers, and plots where scripts
// run.
//
// The page is made from the JSON that --json writes, which it carries, and from pictures: so its numbers are that JSON's. Plots
// are drawn by Vega-Lite, which lies beside the program where the build could fetch it (cmake/AccelReportPlots.cmake); without
// it, and without scripts, the tables say the same. Everything that comes from outside is escaped.
#pragma once

#include <span>
#include <string>

#include "apps/common/report_pictures.h"

namespace accel::apps {

// `json` is what report_json() returns.
std::string report_html(const std::string& json, std::span<const MethodPictures> pictures);

// "Vega-Lite 6.4.3", or why there is none.
std::string report_plots_version();

}  // namespace accel::apps
