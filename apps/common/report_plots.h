// The plots of a report's page: Vega-Lite specifications with their numbers, complete in themselves.
//
// Templates are in apps/report/*.vl.json; what depends on the run is put into them here.
#pragma once

#include <string>
#include <vector>

#include "apps/common/report_data.h"

namespace accel::apps {

struct ReportPlot {
  std::string id;       // in the page
  std::string caption;  // markup
  std::string summary;  // plain: what those hear who do not see it
  Json spec;
};

// Nothing where a run has no such numbers.
std::optional<ReportPlot> pareto_plot(const ReportData& data);
std::optional<ReportPlot> speed_plot(const ReportData& data);
std::optional<ReportPlot> leaf_sizes_plot(const ReportData& data);
std::optional<ReportPlot> leaf_depths_plot(const ReportData& data);
std::optional<ReportPlot> scaling_plot(const ReportData& data);

// A <figure> that scripts draw; nothing of it shows without them.
std::string figure_html(const std::optional<ReportPlot>& plot);

}  // namespace accel::apps
