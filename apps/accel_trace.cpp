// accel-trace: builds structures, traces rays, checks every hit. `accel-trace stress` stress-tests all methods.
#include <string_view>

#include "apps/common/listing.h"
#include "apps/common/output.h"
#include "apps/common/program.h"
#include "apps/common/progress_bar.h"
#include "apps/common/report_html.h"
#include "apps/common/stress_options.h"
#include "apps/common/stress_report.h"
#include "apps/common/stress_run.h"
#include "apps/common/text.h"
#include "apps/common/thread_limit.h"
#include "apps/common/trace_options.h"
#include "apps/common/trace_run.h"

namespace accel::apps {

namespace {

// The report to where the settings want it.
Finished write_report(const TraceReport& report, const TraceSettings& settings, const Terminal& terminal) {
  const bool wants_json = !settings.json.empty() || !settings.report.empty();
  const std::string json = wants_json ? report_json(report, settings) : "";
  const std::string page = settings.report.empty() ? "" : report_html(json, report.pictures);
  for (const auto& [path, text] : {std::pair{&settings.json, &json}, {&settings.report, &page}})
    if (!path->empty() && *path != "-")
      if (auto done = write_text(*path, *text); !done) return done;
  if (settings.json == "-") return terminal.write(json);
  if (settings.report == "-") return terminal.write(page);
  return terminal.write(report_text(report, settings, terminal));
}

Outcome<ExitStatus> trace(int argc, char** argv, Terminal& terminal) {
  const auto settings = parse_trace_options(argc, argv);
  if (!settings) return settings.failure();
  terminal.configure(settings->common.verbosity, settings->common.color);
  if (!settings->help.empty()) return answer(terminal, settings->help);
  if (settings->list) return answer(terminal, listing());

  const ThreadLimit thread_limit(settings->common.threads);
  ProgressBar bar(settings->common.progress, terminal.quiet());
  const auto report = run_trace(*settings, terminal, bar);
  bar.clear();
  if (!report) return report.failure();
  if (auto written = write_report(*report, *settings, terminal); !written) return written.failure();
  if (report->failures() == 0) return ExitStatus::ok;
  return Failure(ExitStatus::mismatch, "verification failed: " + counted(report->failures(), "wrong hit"));
}

Finished write_report(const StressReport& report, const StressSettings& settings, const Terminal& terminal) {
  if (settings.json == "-") return terminal.write(stress_json(report, settings));
  if (!settings.json.empty())
    if (auto done = write_text(settings.json, stress_json(report, settings)); !done) return done;
  return terminal.write(stress_text(report, settings, terminal));
}

Outcome<ExitStatus> stress(int argc, char** argv, Terminal& terminal) {
  const auto settings = parse_stress_options(argc, argv);
  if (!settings) return settings.failure();
  terminal.configure(settings->common.verbosity, settings->common.color);
  if (!settings->help.empty()) return answer(terminal, settings->help);
  if (settings->list) return answer(terminal, stress_listing());

  const ThreadLimit thread_limit(settings->common.threads);
  ProgressBar bar(settings->common.progress, terminal.quiet());
  const auto report = run_stress(*settings, terminal, bar);
  bar.clear();
  if (!report) return report.failure();
  if (auto written = write_report(*report, *settings, terminal); !written) return written.failure();
  const std::uint64_t failures = report->failures(*settings);
  if (failures == 0) return ExitStatus::ok;
  return Failure(ExitStatus::mismatch, "stress test failed: " + counted(failures, "case") + " not as expected");
}

}  // namespace

}  // namespace accel::apps

int main(int argc, char** argv) {
  using namespace accel::apps;
  const bool is_stress = argc > 1 && std::string_view(argv[1]) == "stress";
  return run_program("accel-trace", [&](Terminal& terminal) {
    return is_stress ? stress(argc - 1, argv + 1, terminal) : trace(argc, argv, terminal);
  });
}
