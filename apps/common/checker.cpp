#include "apps/common/checker.h"

#include "apps/common/text.h"

namespace accel::apps {

using validation::CheckResult;
using validation::EmbreeMode;
using validation::EmbreeOptions;
using validation::EmbreeQuality;
using validation::EmbreeWitness;

namespace {

// The witness as an engine, which must not outlive it.
Engine engine_of(const EmbreeWitness& witness, std::string name, int threads) {
  Engine engine;
  engine.name = std::move(name);
  engine.closest = [&witness, threads](std::span<const Ray> rays, std::span<Hit> hits) {
    return timed([&]() -> Status { return witness.closest(rays, hits, threads), Done{}; });
  };
  engine.occluded = [&witness, threads](std::span<const Ray> rays, std::span<std::uint8_t> occluded) {
    return timed([&]() -> Status { return witness.occluded(rays, occluded, threads), Done{}; });
  };
  return engine;
}

}  // namespace

Outcome<Checker> Checker::create(const Scene& scene, const TraceSettings& settings, ProgressBar& bar,
                                 std::vector<Skip>& skipped) {
  Check check = settings.check;
  if (check == Check::embree && !EmbreeWitness::available()) {
    const std::string why = EmbreeWitness::version();
    if (settings.check_given) return Failure(ExitStatus::unavailable, "--check embree: " + why + "; use --check exact or none");
    skipped.push_back({"the comparison with Embree", why});
    check = Check::exact;
  }
  Checker checker(scene, settings, check, bar);
  if (check != Check::embree) return checker;

  // Embree cannot be interrupted: look before each of its builds.
  for (const auto& [mode, slot] : {std::pair{EmbreeMode::fast, &checker.fast_}, {EmbreeMode::robust, &checker.robust_}}) {
    bar.begin("building Embree");
    if (!bar.update(mode == EmbreeMode::fast ? "fast" : "robust", 0)) return Error{std::string(kInterrupted)};
    auto witness = EmbreeWitness::build(scene.mesh(), {mode, EmbreeQuality::medium, settings.common.threads});
    if (!witness) return witness.error();
    *slot = *std::move(witness);
  }
  return checker;
}

Engine Checker::engine() const { return engine_of(*fast_, "Embree", settings_->common.threads); }

Outcome<Answers> Checker::testify(const RayBatch& batch) {
  if (!robust_) return Answers();
  Engine witness = engine_of(*robust_, "Embree robust", settings_->common.threads);
  auto measured = measure({&witness, 1}, batch.rays(), batch.query, 0, *bar_);
  if (!measured) return measured.failure();
  return std::move(measured->front().answers);
}

Outcome<CheckResult> Checker::check(const RayBatch& batch, const Answers& ours, const Answers& witness, bool keep_verdicts) {
  validation::CompareOptions options;
  options.seed = settings_->common.seed;
  options.max_judged = settings_->judge_limit;
  options.threads = settings_->common.threads;
  options.keep_verdicts = keep_verdicts;
  options.progress = bar_->callback();
  auto result = batch.query == Query::closest
                    ? compare(judge(), batch.rays(), ours.hits.span(), witness.hits.span(), options)
                    : compare_any(judge(), batch.rays(), ours.occluded.span(), witness.occluded.span(), options);
  if (!result) return result.error();
  return *std::move(result);
}

Outcome<std::string> Checker::write_bundle(const std::string& stem, const RayBatch& batch, const Answers& ours,
                                           const Answers& witness, const CheckResult& result,
                                           const validation::ReproContext& context) {
  const auto cases = batch.query == Query::closest
                         ? validation::repro_cases(result, batch.rays(), ours.hits.span(), witness.hits.span())
                         : validation::repro_cases(result, batch.rays(), ours.occluded.span(), witness.occluded.span());
  const auto path = validation::write_repro(stem, judge(), cases, context);
  if (!path) return path.error();
  return path->string();
}

std::string Checker::witness_name() const {
  return fast_ ? EmbreeWitness::version() + " (" + fast_->isa() + ")" : std::string();
}

std::string Checker::description() const {
  switch (check_) {
    case Check::embree:
      return "hits checked against " + witness_name() + " robust; differences judged by exact arithmetic";
    case Check::exact:
      return "all hits judged by exact arithmetic";
    case Check::none:
      return "hits not checked";
  }
  return {};
}

const validation::Judge& Checker::judge() {
  if (!judge_) judge_ = std::make_unique<validation::Judge>(scene_->mesh());
  return *judge_;
}

}  // namespace accel::apps
