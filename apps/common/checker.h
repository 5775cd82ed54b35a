// Who checks a run's answers, and what it takes: Embree's scenes and the judge, built when they are first needed.
//
// Two Embree scenes: the fast one is timed, the robust one is the witness of hits.
//
// Methods that do not keep a scene's instances apart trace their triangles rounded to floats, another scene to exact
// arithmetic: they have a witness and a judge of their own (Truth).
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

  // What a method traces: the scene as it is, or its instances as one mesh.
  enum class Truth { as_it_is, one_mesh };
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

  // "Embree 3.13.5 (avx2)" or empty; and how hits are checked, in a sentence.
  std::string witness_name() const;
  std::string description() const;

  // The judge; built at the first call. There is one for every truth that truth_of() has told.
  const validation::Judge& judge(Truth truth);

 private:
  Checker(const Scene& scene, const TraceSettings& settings, Check check, ProgressBar& bar)
      : scene_(&scene), settings_(&settings), check_(check), bar_(&bar) {}

  // The witness and the judge of one truth, each made when it is first needed.
  struct Court {
    std::optional<validation::EmbreeWitness> robust;
    std::unique_ptr<validation::Judge> judge;
  };
  Court& court(Truth truth) { return courts_[static_cast<int>(truth)]; }
  Result<validation::EmbreeWitness> make_witness(validation::EmbreeMode mode, Truth truth) const;

  const Scene* scene_;
  const TraceSettings* settings_;
  Check check_;
  ProgressBar* bar_;
  std::optional<validation::EmbreeWitness> fast_;
  Court courts_[2];
};

}  // namespace accel::apps
