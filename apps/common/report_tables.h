// The tables of a report's page, as markup; empty where a run has no such numbers.
#pragma once

#include <string>

#include "apps/common/report_data.h"

namespace accel::apps {

std::string summary_table(const ReportData& data);  // the best of each kind of rays
std::string speed_table(const ReportData& data);
std::string verdicts_table(const ReportData& data);
std::string adjudication_table(const ReportData& data);
std::string structures_table(const ReportData& data);
std::string counters_table(const ReportData& data);
std::string simt_table(const ReportData& data);
std::string multipass_table(const ReportData& data);
std::string sort_table(const ReportData& data);
std::string scaling_table(const ReportData& data);

}  // namespace accel::apps
