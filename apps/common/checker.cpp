#include "apps/common/checker.h"

#include "apps/common/embree_rivals.h"
#include "apps/common/text.h"

namespace accel::apps {

using validation::CheckResult;
using validation::EmbreeMode;
using validation::EmbreeQuality;
using validation::EmbreeWitness;

Outcome<Checker> Checker::create(const Scene& scene, const TraceSettings& settings, EmbreeScenes& embree, ProgressBar& bar,
                                 std::vector<Skip>& skipped) {
  Check check = settings.check;
  if (check == Check::embree && !EmbreeWitness::available()) {
    const std::string why = EmbreeWitness::version();
    if (settings.check_given) return Failure(ExitStatus::unavailable, "--check embree: " + why + "; use --check exact or none");
    skipped.push_back({"the comparison with Embree", why});
    check = Check::exact;
  }
  return Checker(scene, settings, embree, check, bar);
}

Truth Checker::truth_of(const MethodInfo& method) const {
  return scene_->data.instances && !method.instances ? Truth::one_mesh : Truth::as_it_is;
}

Outcome<Answers> Checker::testify(const RayBatch& batch, Truth truth) {
  if (check_ != Check::embree) return Answers();
  const auto robust = embree_->get(EmbreeMode::robust, EmbreeQuality::medium, truth);
  if (!robust) return robust.error();
  Engine witness = engine_of(kEmbreeModes[1], **robust, settings_->common.threads);
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

std::string Checker::description() const {
  switch (check_) {
    case Check::embree:
      return "hits checked against " + embree_->name() + " robust; differences judged by exact arithmetic";
    case Check::exact:
      return "all hits judged by exact arithmetic";
    case Check::none:
      return "hits not checked";
  }
  return {};
}

const validation::Judge& Checker::judge(Truth truth) {
  std::unique_ptr<validation::Judge>& judge = judges_[static_cast<int>(truth)];
  if (judge) return *judge;
  if (scene_->data.instances && truth == Truth::as_it_is)
    return *(judge = std::make_unique<validation::Judge>(*scene_->data.instances));
  // There is one mesh: a method has been built over it.
  return *(judge = std::make_unique<validation::Judge>(*scene_->data.one_mesh()));
}

}  // namespace accel::apps
