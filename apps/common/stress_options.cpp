#include "apps/common/stress_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "apps/common/command_line.h"
#include "apps/common/output.h"
#include "apps/common/text.h"
#include "libaccel/registry/any_accel.h"
#include "validation/oracle/embree.h"

namespace accel::apps {

namespace {

constexpr const char* kStressDescription =
    "Stress-tests the numerical stability of methods: rays and scenes that hurt, laws that must hold,\n"
    "leaks through closed meshes; every case with what is expected of it, beside Embree on the same rays.\n"
    "(A scene in a file named stress is ./stress.)";

constexpr const char* kStressExamples =
    "Examples:\n"
    "  accel-trace stress                                 every case and method, some thousand rays each\n"
    "  accel-trace stress --list                          what is traced, and what is expected\n"
    "  accel-trace stress --case leaks --method best --rays 1e9 --resume leaks.state\n"
    "                                                     does anything leak? Go on later from the file\n"
    "  accel-trace stress --hours 8 --seed 2 --json -     more rays and larger scenes until morning\n"
    "\n"
    "Exit status: 0 all is as expected, 1 failure, 2 bad command line, 3 something is not as expected,\n"
    "130 interrupted (143 by SIGTERM).";

constexpr double kMostRays = 1e13;
constexpr std::uint64_t kDefaultRays = 20'000;

struct RawStressOptions {
  std::string methods = "all", cases = "all", rays, witness = "embree";
};

void add_options(CLI::App& app, StressSettings& settings, RawStressOptions& raw) {
  const auto add = [&](const char* flag, auto& value, const char* what, const char* type) {
    return app.add_option(flag, value, what)->type_name(type);
  };
  add("-m,--method", raw.methods, "methods (builder/traverser), best, or all", "NAME,...")
      ->capture_default_str()
      ->group("What");
  add("--case", raw.cases, "cases, families of them (rays, geometry, laws, leaks), or all", "NAME,...")
      ->capture_default_str()
      ->group("What");
  app.add_flag("--list", settings.list, "list the cases with what is expected of them, and exit")->group("What");
  add("--rays", raw.rays, "rays of each case and method, as 20000 or 1e9\n[20000; with --hours no limit]", "N")
      ->group("How much");
  add("--hours", settings.hours, "goes on with more rays and larger scenes for so long", "H")
      ->check(real_number(1e-6, 1e5))
      ->group("How much");
  add("--witness", raw.witness, "who traces the same rays: embree or none", "WHO")->capture_default_str()->group("How much");
  add("--resume", settings.resume, "keeps the state in this file, and goes on from it", "FILE")->group("Output");
  add("--json", settings.json, "all rows; - is standard output, instead of the table", "FILE")->group("Output");
  add("--repro", settings.repro, "how names of files that reproduce failures begin", "STEM")
      ->capture_default_str()
      ->group("Output");
}

Outcome<std::uint64_t> parse_rays(const std::string& text) {
  double rays = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rays);
  const bool whole =
      error == std::errc() && end == text.data() + text.size() && rays >= 1 && rays <= kMostRays && rays == std::floor(rays);
  if (!whole) return usage_error("--rays: '" + text + "' should be a whole number from 1 to 1e13");
  return static_cast<std::uint64_t>(rays);
}

template <class T>
void add_once(std::vector<T>& list, const T& value) {
  if (std::find(list.begin(), list.end(), value) == list.end()) list.push_back(value);
}

Finished parse_methods(const std::string& text, std::vector<std::string>& names) {
  for (const std::string& name : split(text, ',')) {
    if (name == "all") {
      for (const MethodInfo& m : methods())
        if (m.robust) add_once(names, m.name);
      continue;
    }
    const Result<std::string> found = find_method(name);
    if (!found) return usage_error("--method: " + found.message());
    add_once(names, *found);
  }
  return Done{};
}

Finished parse_cases(const std::string& text, std::vector<const validation::StressCase*>& cases) {
  for (const std::string& name : split(text, ',')) {
    if (name == "all") {
      for (const validation::StressCase& one : validation::stress_cases()) add_once(cases, &one);
      continue;
    }
    const auto found = validation::find_cases(name);
    if (!found) return usage_error("--case: " + found.message());
    for (const validation::StressCase* one : *found) add_once(cases, one);
  }
  return Done{};
}

Finished interpret(const RawStressOptions& raw, StressSettings& settings) {
  if (auto done = parse_methods(raw.methods, settings.methods); !done) return done;
  if (auto done = parse_cases(raw.cases, settings.cases); !done) return done;
  settings.rays = settings.hours > 0 ? 0 : kDefaultRays;
  if (!raw.rays.empty()) {
    const auto rays = parse_rays(raw.rays);
    if (!rays) return rays.failure();
    settings.rays = *rays;
  }
  if (raw.witness != "embree" && raw.witness != "none")
    return usage_error("--witness: '" + raw.witness + "' should be embree or none");
  settings.embree = raw.witness == "embree" && validation::EmbreeWitness::available();
  return check_outputs({{"--resume", settings.resume}, {"--json", settings.json}}, {});
}

}  // namespace

Outcome<StressSettings> parse_stress_options(int argc, char** argv) {
  CLI::App app(kStressDescription, "accel-trace stress");
  StressSettings settings;
  RawStressOptions raw;
  add_options(app, settings, raw);
  add_common_options(app, settings.common);
  app.footer(kStressExamples);

  auto answer = parse_arguments(app, argc, argv, settings.common);
  if (!answer) return answer.failure();
  settings.help = *answer;
  if (!settings.help.empty() || settings.list) return settings;
  if (auto done = interpret(raw, settings); !done) return done.failure();
  return settings;
}

}  // namespace accel::apps
