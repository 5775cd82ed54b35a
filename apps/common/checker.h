// Who checks a run's answers: Embree's robust scene as the witness of hits, and the judge, built when they are first needed.
//
// Methods that do not keep a scene's instances apart trace their triangles rounded to floats, another scene to exact
// arithmetic: they have a witness and a judge of their own (Truth).
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "apps/common/embree_scenes.h"
#include "apps/common/measure.h"
#include "apps/common/ray_batch.h"
#include "apps/common/trace_report.h"
#include "validation/compare/compare.h"
#include "validation/compare/repro.h"

namespace accel::apps {

class Checker {
 public:
  // Without Embree, --check embree is unavailable; as a default it gives way to exact. All arguments but the last outlive the
  // checker.
  static Outcome<Checker> create(const Scene& scene, const TraceSettings& settings, EmbreeScenes& embree, ProgressBar& bar,
                                 std::vector<Skip>& skipped);

  bool checks() const { return check_ != Check::none; }
  bool has_witness() const { return check_ == Check::embree; }

  Truth truth_of(const MethodInfo& method) const;

  // The witness's answers to a batch; empty without a witness.
  Outcome<Answers> testify(const RayBatch& batch, Truth truth);

  // Compares and judges.
  Outcome<validation::CheckResult> check(const RayBatch& batch, Truth truth, const Answers& ours, const Answers& witness,
                                         bool keep_verdicts);

  // Writes what reproduces the failures of a comparison; returns the path of the part for people.
  Outcome<std::string> write_bundle(const std::string& stem, const RayBatch& batch, Truth truth, const Answers& ours,
                                    const Answers& witness, const validation::CheckResult& result,
                                    const validation::ReproContext& context);

  // How hits are checked, in a sentence, once Embree's first scene has been built.
  std::string description() const;

  // The judge; built at the first call. There is one for every truth that truth_of() has told.
  const validation::Judge& judge(Truth truth);

 private:
  Checker(const Scene& scene, const TraceSettings& settings, EmbreeScenes& embree, Check check, ProgressBar& bar)
      : scene_(&scene), settings_(&settings), embree_(&embree), check_(check), bar_(&bar) {}

  const Scene* scene_;
  const TraceSettings* settings_;
  EmbreeScenes* embree_;
  Check check_;
  ProgressBar* bar_;
  std::unique_ptr<validation::Judge> judges_[2];  // by truth
};

}  // namespace accel::apps
