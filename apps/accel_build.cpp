// accel-build: builds a structure and writes it to a file.
#include "apps/common/build_options.h"
#include "apps/common/build_run.h"
#include "apps/common/listing.h"
#include "apps/common/output.h"
#include "apps/common/program.h"
#include "apps/common/thread_limit.h"

namespace accel::apps {

namespace {

Outcome<ExitStatus> build(int argc, char** argv, Terminal& terminal) {
  const auto settings = parse_build_options(argc, argv);
  if (!settings) return settings.failure();
  terminal.configure(settings->common.verbosity, settings->common.color);
  if (!settings->help.empty()) return answer(terminal, settings->help);
  if (settings->list) return answer(terminal, listing());

  const ThreadLimit thread_limit(settings->common.threads);
  ProgressBar bar(settings->common.progress, terminal.quiet());
  const auto report = run_build(*settings, bar);
  bar.clear();
  if (!report) return report.failure();
  if (settings->json == "-") return answer(terminal, build_report_json(*report, *settings));
  if (!settings->json.empty())
    if (auto done = write_text(settings->json, build_report_json(*report, *settings)); !done) return done.failure();
  return answer(terminal, build_report_text(*report, *settings, terminal));
}

}  // namespace

}  // namespace accel::apps

int main(int argc, char** argv) {
  using namespace accel::apps;
  return run_program("accel-build", [&](Terminal& terminal) { return build(argc, argv, terminal); });
}
