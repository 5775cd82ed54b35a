// Who checks a run's answers, and what it takes: Embree's scenes and the judge, built when they are first needed.
//
// Two Embree scenes: the fast one is timed, the robust one is the witness of hits.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "apps/common/measure.h"
#include "apps/common/ray_batch.h"
#include "apps/common/trace_report.h"
#include "validation/compare/compare.h"
#include "validation/compare/repro.h"
#include "validation/oracle/embree.h"

namespace accel::apps {

class Checker {
 public:
  // Builds the witness, if there is to be one. Without Embree, --check embree is unavailable; as a default it gives way to
  // exact.
  static Outcome<Checker> create(const Scene& scene, const TraceSettings& settings, ProgressBar& bar,
                                 std::vector<Skip>& skipped);

  bool checks() const { return check_ != Check::none; }
  const std::optional<validation::EmbreeWitness>& fast() const { return fast_; }

  // The witness as an engine to be timed. The checker must outlive it.
  Engine engine() const;

  // The witness's answers to a batch; empty without a witness.
  Outcome<Answers> testify(const RayBatch& batch);

  // Compares and judges.
  Outcome<validation::CheckResult> check(const RayBatch& batch, const Answers& ours, const Answers& witness,
                                         bool keep_verdicts);

  // Writes what reproduces the failures of a comparison; returns the path of the part for people.
  Outcome<std::string> write_bundle(const std::string& stem, const RayBatch& batch, const Answers& ours, const Answers& witness,
                                    const validation::CheckResult& result, const validation::ReproContext& context);

  // "Embree 3.13.5 (avx2)" or empty; and how hits are checked, in a sentence.
  std::string witness_name() const;
  std::string description() const;

  // The judge; built at the first call.
  const validation::Judge& judge();

 private:
  Checker(const Scene& scene, const TraceSettings& settings, Check check, ProgressBar& bar)
      : scene_(&scene), settings_(&settings), check_(check), bar_(&bar) {}

  const Scene* scene_;
  const TraceSettings* settings_;
  Check check_;
  ProgressBar* bar_;
  std::optional<validation::EmbreeWitness> fast_, robust_;
  std::unique_ptr<validation::Judge> judge_;
};

}  // namespace accel::apps
