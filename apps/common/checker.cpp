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

  auto fast = checker.make_witness(EmbreeMode::fast, Truth::as_it_is);
  if (!fast) return fast.error();
  checker.fast_ = *std::move(fast);
  return checker;
}

// Embree cannot be interrupted: looks before each of its builds.
Result<EmbreeWitness> Checker::make_witness(EmbreeMode mode, Truth truth) const {
  bar_->begin("building Embree");
  if (!bar_->update(mode == EmbreeMode::fast ? "fast" : "robust", 0)) return Error{std::string(kInterrupted)};
  const EmbreeOptions options{mode, EmbreeQuality::medium, settings_->common.threads};
  if (scene_->data.instances && truth == Truth::as_it_is) return EmbreeWitness::build(*scene_->data.instances, options);
  const auto mesh = scene_->data.one_mesh();
  return mesh ? EmbreeWitness::build(*mesh, options) : mesh.error();
}

Checker::Truth Checker::truth_of(const MethodInfo& method) const {
  return scene_->data.instances && !method.instances ? Truth::one_mesh : Truth::as_it_is;
}

Engine Checker::engine() const { return engine_of(*fast_, "Embree", settings_->common.threads); }

Outcome<Answers> Checker::testify(const RayBatch& batch, Truth truth) {
  if (check_ != Check::embree) return Answers();
  std::optional<EmbreeWitness>& robust = court(truth).robust;
  if (!robust) {
    auto made = make_witness(EmbreeMode::robust, truth);
    if (!made) return made.error();
    robust = *std::move(made);
  }
  Engine witness = engine_of(*robust, "Embree robust", settings_->common.threads);
  auto measured = measure({&witness, 1}, batch.rays(), batch.query, 0, *bar_);
  if (!measured) return measured.failure();
  return std::move(measured->front().answers);
}

Outcome<CheckResult> Checker::check(const RayBatch& batch, Truth truth, const Answers& ours, const Answers& witness,
                                    bool keep_verdicts) {
  validation::CompareOptions options;
  options.seed = settings_->common.seed;
  options.max_judged = settings_->judge_limit;
  options.threads = settings_->common.threads;
  options.keep_verdicts = keep_verdicts;
  options.progress = bar_->callback();
  auto result = batch.query == Query::closest
                    ? compare(judge(truth), batch.rays(), ours.hits.span(), witness.hits.span(), options)
                    : compare_any(judge(truth), batch.rays(), ours.occluded.span(), witness.occluded.span(), options);
  if (!result) return result.error();
  return *std::move(result);
}

Outcome<std::string> Checker::write_bundle(const std::string& stem, const RayBatch& batch, Truth truth, const Answers& ours,
                                           const Answers& witness, const CheckResult& result,
                                           const validation::ReproContext& context) {
  const auto cases = batch.query == Query::closest
                         ? validation::repro_cases(result, batch.rays(), ours.hits.span(), witness.hits.span())
                         : validation::repro_cases(result, batch.rays(), ours.occluded.span(), witness.occluded.span());
  const auto path = validation::write_repro(stem, judge(truth), cases, context);
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

const validation::Judge& Checker::judge(Truth truth) {
  std::unique_ptr<validation::Judge>& judge = court(truth).judge;
  if (judge) return *judge;
  if (scene_->data.instances && truth == Truth::as_it_is)
    return *(judge = std::make_unique<validation::Judge>(*scene_->data.instances));
  // There is one mesh: a method has been built over it.
  return *(judge = std::make_unique<validation::Judge>(*scene_->data.one_mesh()));
}

}  // namespace accel::apps
