// accel-trace: builds structures, traces rays, checks every hit.
#include "apps/common/listing.h"
#include "apps/common/output.h"
#include "apps/common/program.h"
#include "apps/common/progress_bar.h"
#include "apps/common/report_html.h"
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

}  // namespace

}  // namespace accel::apps

int main(int argc, char** argv) {
  using namespace accel::apps;
  return run_program("accel-trace", [&](Terminal& terminal) { return trace(argc, argv, terminal); });
}
