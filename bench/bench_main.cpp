#include "bench/bench_main.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string_view>
#include <vector>

namespace accel::bench {

namespace {

struct Times {
  std::vector<double> seconds;

  double median() const {
    std::vector<double> sorted = seconds;
    std::sort(sorted.begin(), sorted.end());
    const std::size_t n = sorted.size();
    return n % 2 == 1 ? sorted[n / 2] : 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]);
  }
};

// Prints as the console reporter does, and keeps the times of single repetitions for the table.
class TableReporter : public benchmark::ConsoleReporter {
 public:
  TableReporter() : ConsoleReporter(OO_Tabular) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration || run.error_occurred || run.iterations == 0) continue;
      const std::string& name = run.run_name.function_name;
      const std::size_t bar = name.rfind('|');
      if (bar == std::string::npos) continue;
      const double seconds = run.real_accumulated_time / static_cast<double>(run.iterations);
      groups_[name.substr(0, bar)][name.substr(bar + 1)].seconds.push_back(seconds);
    }
  }

  // Ratios are to the row `baseline` of a group.
  void print_table(const std::string& baseline) const {
    std::printf("\n%-40s %-18s %12s %22s %10s\n", "group", "row", "median (ms)", "min ... max (ms)", ("x " + baseline).c_str());
    for (const auto& [group, rows] : groups_) {
      const auto base = rows.find(baseline);
      for (const auto& [row, times] : rows) {
        const auto [least, most] = std::minmax_element(times.seconds.begin(), times.seconds.end());
        std::printf("%-40s %-18s %12.3f %10.3f ... %7.3f", group.c_str(), row.c_str(), times.median() * 1e3, *least * 1e3,
                    *most * 1e3);
        if (base != rows.end()) std::printf(" %10.3f", base->second.median() / times.median());
        std::printf("\n");
      }
    }
  }

 private:
  std::map<std::string, std::map<std::string, Times>> groups_;
};

// The arguments with our defaults before them, so that the caller's win.
std::vector<std::string> with_defaults(int argc, char** argv) {
  std::vector<std::string> arguments = {argv[0], "--benchmark_enable_random_interleaving=true", "--benchmark_repetitions=5",
                                        "--benchmark_min_time=0.1"};
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  return arguments;
}

}  // namespace

int run(int argc, char** argv, const std::function<Status(const Options&)>& register_benchmarks, const std::string& baseline) {
  const Result<Options> options = parse_options(argc, argv);
  if (!options) return std::fprintf(stderr, "error: %s\n", options.message().c_str()), 2;

  std::vector<std::string> arguments = with_defaults(argc, argv);
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  int count = static_cast<int>(pointers.size());
  benchmark::Initialize(&count, pointers.data());
  if (benchmark::ReportUnrecognizedArguments(count, pointers.data())) return 2;

  if (const Status registered = register_benchmarks(*options); !registered)
    return std::fprintf(stderr, "error: %s\n", registered.message().c_str()), 1;
  TableReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.print_table(baseline);
  return 0;
}

}  // namespace accel::bench
