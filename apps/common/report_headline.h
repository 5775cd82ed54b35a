// The first thing on a report's page: what was run, what was found, and what is wrong, as markup.
#pragma once

#include <string>

#include "apps/common/report_data.h"

namespace accel::apps {

// The scene's name without its folder, for the title; not escaped.
std::string scene_title(const ReportData& data);

// Wrong hits and answers that sorting changed; empty where there are none.
std::string alarm_html(const ReportData& data);

// A sentence or two: the fastest method without a wrong hit on the first kind of rays, and whose hits are wrong how often. Or
// the advice of a sweep.
std::string finding_html(const ReportData& data);

// Machine, date, versions, what was traced.
std::string facts_html(const ReportData& data);

}  // namespace accel::apps
