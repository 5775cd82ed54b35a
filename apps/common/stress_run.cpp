#include "apps/common/stress_run.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "apps/common/output.h"
#include "apps/common/text.h"
#include "libaccel/core/counter_rng.h"

namespace accel::apps {

namespace {

using validation::SceneSize;
using validation::StressCase;
using validation::StressFailure;

constexpr std::uint64_t kFirstRound = 1024, kMostInRound = 1 << 24;  // rays
constexpr std::uint64_t kMostOfVerdicts = 1 << 20;                   // where all of a scene's rays are in memory at once
constexpr std::uint64_t kFirstLargeRound = 3;
constexpr std::size_t kMostBundles = 16;
constexpr std::size_t kMostTriangles = 200'000;  // in a bundle
constexpr auto kSaveInterval = std::chrono::seconds(1);

std::uint64_t rays_of_round(std::uint64_t round, bool leaks) {
  const std::uint64_t most = leaks ? kMostInRound : kMostOfVerdicts;
  return round >= 12 ? most : std::min(most, kFirstRound << (2 * round));
}

std::string file_name_of(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '/' || c == ' '; }, '-');
  return text;
}

std::string obj_text(const TriangleMesh& mesh) {
  std::string text;
  for (const Vec3& v : mesh.vertices) text += print("v %.9g %.9g %.9g\n", v.x, v.y, v.z);
  for (const IndexTriple& t : mesh.triangles) text += print("f %u %u %u\n", t.v0 + 1, t.v1 + 1, t.v2 + 1);
  return text;
}

class StressProgram {
 public:
  StressProgram(const StressSettings& settings, const Terminal& terminal, ProgressBar& bar, StressState state)
      : settings_(settings), terminal_(terminal), bar_(bar), begin_(Clock::now()), seconds_before_(state.seconds) {
    report_.state = std::move(state);
  }

  Outcome<StressReport> run() {
    for (std::uint64_t round = 0; !is_over(); ++round) {
      if (auto done = run_round(round); !done) return done.failure();
      if (is_complete()) break;
    }
    if (auto saved = save(); !saved) return saved.failure();
    return std::move(report_);
  }

 private:
  using Clock = std::chrono::steady_clock;

  double elapsed() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }
  bool is_over() const { return settings_.hours > 0 && elapsed() >= settings_.hours * 3600; }
  std::uint64_t target() const { return settings_.rays > 0 ? settings_.rays : std::numeric_limits<std::uint64_t>::max(); }

  bool is_complete() {
    for (const StressCase* one : settings_.cases)
      for (const std::string& method : settings_.methods)
        if (entry(*one, method).asked < target()) return false;
    return true;
  }

  StressEntry& entry(const StressCase& one, const std::string& engine) {
    return report_.state.entries[{std::string(one.name), engine}];
  }

  Finished run_round(std::uint64_t round) {
    for (const StressCase* one : settings_.cases)
      for (const std::string& method : settings_.methods) {
        StressEntry& mine = entry(*one, method);
        if (mine.rounds > round || mine.asked >= target()) continue;
        if (is_over()) return Done{};
        if (auto done = run_one(*one, method, round, mine); !done) return done;
      }
    return Done{};
  }

  Finished run_one(const StressCase& one, const std::string& method, std::uint64_t round, StressEntry& mine) {
    const bool leaks = one.scenes == nullptr;
    validation::StressRun run;
    run.method = method;
    run.rays = std::min(rays_of_round(round, leaks), target() - mine.asked);
    run.seed = mix_bits(settings_.common.seed * 1'000'003 + round) >> 24;
    run.size = round < kFirstLargeRound ? SceneSize::small : SceneSize::large;
    run.witness = settings_.embree ? validation::StressWitness::embree : validation::StressWitness::brute_force;
    run.threads = settings_.common.threads;
    bar_.begin(std::string(one.name) + " by " + method + ", " + counted(run.rays, "ray"));
    run.progress = bar_.callback();
    run.on_failure = [&](const StressFailure& failure) { keep(failure, one, method, mine); };
    const Result<validation::StressOutcome> outcome = run_case(one, run);
    if (!outcome && outcome.message() == kInterrupted) return interrupted_run();
    if (outcome)
      add(one, round, *outcome, mine);
    else if (mine.error.empty())
      mine.error = outcome.message();
    mine.rounds = round + 1, mine.asked += run.rays;
    return Clock::now() - last_save_ < kSaveInterval ? Finished(Done{}) : save();
  }

  void add(const StressCase& one, std::uint64_t round, const validation::StressOutcome& outcome, StressEntry& mine) {
    mine.tally += outcome.ours;
    for (const auto& [name, tally] : {std::pair{kEmbreeRobust, outcome.robust}, {kEmbreeFast, outcome.fast}}) {
      if (tally.rays == 0) continue;
      StressEntry& theirs = entry(one, name);
      if (theirs.rounds > round) continue;  // the same rays as beside another method
      theirs.tally += tally;
      theirs.rounds = round + 1;
    }
  }

  // What is needed to look at a failure again: the scene, the rays and what exact arithmetic says of them. One bundle for each
  // method and case.
  void keep(const StressFailure& failure, const StressCase& one, const std::string& method, StressEntry& mine) {
    if (failure.cases.empty() && mine.error.empty()) mine.error = failure.scene + ": " + failure.what;
    const std::string stem = settings_.repro + "-" + file_name_of(std::string(failure.case_name) + "-" + method);
    const bool again = std::find(bundles_.begin(), bundles_.end(), stem) != bundles_.end();
    if (again || bundles_.size() >= kMostBundles || failure.cases.empty()) return;
    bundles_.push_back(stem);
    std::string scene = stem + "-scene.obj";
    if (failure.mesh->size() > kMostTriangles)
      scene = stem + ".obj";
    else if (const auto written = write_text(scene, obj_text(*failure.mesh)); !written)
      return terminal_.warning(written.failure().message);
    const auto text =
        validation::write_repro(stem, validation::Judge(*failure.mesh), failure.cases,
                                {.command_line = settings_.common.command_line, .scene = scene, .method = method});
    if (!text) return terminal_.warning(text.message());
    report_.bundles.push_back({&one, method, text->string() + ": " + failure.scene + ", " + failure.what});
  }

  Failure interrupted_run() {
    if (auto saved = save(); !saved) return saved.failure();
    return {
        interruption_status(),
        std::string(kInterrupted) + (settings_.resume.empty() ? "" : "; --resume " + settings_.resume + " goes on from here")};
  }

  Finished save() {
    last_save_ = Clock::now();
    report_.state.seconds = seconds_before_ + elapsed();
    return save_stress_state(settings_.resume, report_.state);
  }

  const StressSettings& settings_;
  const Terminal& terminal_;
  ProgressBar& bar_;
  Clock::time_point begin_, last_save_{};
  double seconds_before_;
  StressReport report_;
  std::vector<std::string> bundles_;  // their stems
};

}  // namespace

bool is_failure(const StressCase& one, const StressEntry& entry) {
  return !entry.error.empty() || !validation::is_as_expected(one, entry.tally);
}

std::uint64_t StressReport::failures(const StressSettings& settings) const {
  std::uint64_t count = 0;
  for (const StressCase* one : settings.cases)
    for (const std::string& method : settings.methods) {
      const auto found = state.entries.find({std::string(one->name), method});
      count += found != state.entries.end() && is_failure(*one, found->second);
    }
  return count;
}

Outcome<StressReport> run_stress(const StressSettings& settings, const Terminal& terminal, ProgressBar& bar) {
  auto state = load_stress_state(settings.resume, settings.common.seed);
  if (!state) return state.failure();
  return StressProgram(settings, terminal, bar, *std::move(state)).run();
}

}  // namespace accel::apps
