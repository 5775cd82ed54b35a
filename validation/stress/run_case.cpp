#include "validation/stress/run_case.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "libaccel/build/grid.h"
#include "libaccel/registry/any_accel.h"
#include "validation/compare/same_hit.h"
#include "validation/oracle/embree.h"
#include "validation/stress/leaks.h"

namespace accel::validation {
namespace {

constexpr std::uint64_t kMostBruteForceTests = 200'000'000;
constexpr std::uint64_t kMostUnwitnessed = 20'000;  // rays judged of a scene that has no witness
constexpr std::size_t kMostReported = 8;            // of any-hit answers

// The most references that a builder may make, by what its header promises; 0 where it promises nothing.
double reference_limit(const MethodInfo& method, const BuildReport& report) {
  const BuildOptions defaults;
  const auto triangles = static_cast<double>(report.triangles);
  if (method.builder == "sbvh" || method.builder == "bvh8") return (1 + double{defaults.max_duplication}) * triangles;
  const double most = double{defaults.max_references} * triangles;
  if (method.builder == "kdtree") return most;
  if (method.builder == "grid") return std::max(most, static_cast<double>(kFreeReferences));
  return 0;
}

class CaseRun {
 public:
  CaseRun(const StressCase& one, const StressRun& run) : case_(one), run_(run) {}

  Result<StressOutcome> run() {
    const std::vector<StressScene> scenes = case_.scenes(run_.size, run_.seed);
    for (std::size_t s = 0; s < scenes.size(); ++s) {
      if (run_.progress && !run_.progress(case_.name, static_cast<double>(s) / static_cast<double>(scenes.size())))
        return Error{std::string(kInterrupted)};
      const std::uint64_t share = (run_.rays + scenes.size() - 1) / scenes.size();
      const Status done = case_.expected == Expected::lawful        ? check_law_on(scenes[s], share)
                          : case_.expected == Expected::build_error ? expect_no_build(scenes[s])
                                                                    : trace(scenes[s], affordable(scenes[s].mesh, share));
      if (!done) return done.error();
    }
    return outcome_;
  }

 private:
  const MethodInfo& method() const {
    return *std::find_if(methods().begin(), methods().end(), [&](const MethodInfo& m) { return m.name == run_.method; });
  }

  // No more rays than the case and an exhaustive method allow.
  std::uint64_t affordable(const TriangleMesh& mesh, std::uint64_t rays) const {
    if (run_.size == SceneSize::large && case_.most_large_rays > 0) rays = std::min(rays, case_.most_large_rays);
    if (method().exhaustive) rays = std::min(rays, kMostBruteForceTests / std::max<std::uint64_t>(1, mesh.size()));
    return rays;
  }

  void report(const StressScene& scene, const std::string& what, std::vector<ReproCase> cases) const {
    if (run_.on_failure) run_.on_failure({case_.name, scene.name, what, &scene.mesh, std::move(cases)});
  }

  Status check_law_on(const StressScene& scene, std::uint64_t rays) {
    if (!has_range_for(case_.law, scene)) return Done{};
    const Result<LawResult> result = check_law(case_.law, scene, rays_of_kind(RayKind::mixed, scene.mesh, rays, run_.seed),
                                               {run_.method, "watertight", run_.threads});
    if (!result) return result.error();
    outcome_.ours.rays += result->rays, outcome_.ours.broken += result->broken;
    if (result->broken > 0) report(scene, result->what, result->cases);
    return Done{};
  }

  Status expect_no_build(const StressScene& scene) {
    ++outcome_.ours.rays;
    const Result<AnyAccel> accel = AnyAccel::build(scene.mesh, run_.method);
    if (!accel && !accel.message().empty()) return Done{};
    ++outcome_.ours.broken;
    report(scene, "the build did not fail", {});
    return Done{};
  }

  Status trace(const StressScene& scene, std::uint64_t count) {
    const Result<AnyAccel> accel =
        AnyAccel::build(scene.mesh, run_.method, {.threads = run_.threads, .progress = run_.progress});
    if (!accel) return accel.error();
    check_budget(scene, accel->report());
    const std::vector<Ray> rays = rays_of_kind(case_.rays, scene.mesh, count, run_.seed);
    std::vector<Hit> hits(rays.size());
    std::vector<std::uint8_t> any(rays.size());
    if (Status s = accel->closest(rays, hits, {.threads = run_.threads}); !s) return s;
    if (Status s = accel->occluded(rays, any, {.threads = run_.threads}); !s) return s;
    outcome_.ours.rays += rays.size();
    expect_same_occlusion(scene, rays, hits, any);
    if (case_.expected == Expected::all_misses) return expect_misses(scene, rays, hits), Done{};
    if (case_.expected == Expected::first_of_copies) return expect_first(scene, rays, hits);
    return judge(scene, rays, hits);
  }

  // Instances build a tree for each mesh, and a budget for each.
  void check_budget(const StressScene& scene, const BuildReport& built) {
    const double limit = reference_limit(method(), built);
    if (limit == 0 || static_cast<double>(built.references) <= limit) return;
    ++outcome_.ours.broken;
    report(scene, std::to_string(built.references) + " references of " + std::to_string(built.triangles) + " triangles", {});
  }

  void expect_same_occlusion(const StressScene& scene, const std::vector<Ray>& rays, const std::vector<Hit>& hits,
                             const std::vector<std::uint8_t>& any) {
    std::vector<ReproCase> wrong;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if ((any[i] != 0) == hits[i].valid()) continue;
      ++outcome_.ours.broken;
      if (wrong.size() < kMostReported) wrong.push_back({i, rays[i], Verdict::unjudged, hits[i], std::nullopt});
    }
    if (!wrong.empty()) report(scene, "any-hit queries say otherwise", std::move(wrong));
  }

  void expect_misses(const StressScene& scene, const std::vector<Ray>& rays, const std::vector<Hit>& hits) {
    std::vector<ReproCase> wrong;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (same_hit(hits[i], Hit{})) continue;
      ++outcome_.ours.false_hit;
      if (wrong.size() < kMostReported) wrong.push_back({i, rays[i], Verdict::false_hit, hits[i], std::nullopt});
    }
    if (!wrong.empty()) report(scene, "hits where there is nothing", std::move(wrong));
  }

  // Copies are never named, so only the first of them need be tested. Where bits differ, exact arithmetic may excuse it: a hit
  // that rounding moved out of its box may be found in the box of one copy, and cull the boxes of the others. A copy that is
  // hit beyond doubt is never excused.
  Status expect_first(const StressScene& scene, const std::vector<Ray>& rays, const std::vector<Hit>& hits) {
    const TriangleMesh firsts = without_copies(scene.mesh);
    const Result<AnyAccel> brute = AnyAccel::build(firsts, "brute/loop");
    if (!brute) return brute.error();
    std::vector<Hit> expected(rays.size());
    if (Status s = brute->closest(rays, expected, {.threads = run_.threads}); !s) return s;
    const Judge judge(firsts);
    std::vector<ReproCase> wrong;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (same_hit(hits[i], expected[i])) continue;
      Hit first = hits[i];
      if (first.valid()) first.prim_id %= static_cast<std::uint32_t>(firsts.size());
      const Verdict verdict = judge.judge(rays[i], first, judge.oracle().closest(rays[i]));
      const bool is_copy = first.prim_id != hits[i].prim_id;
      ++outcome_.ours.judged;
      if (!is_failure(verdict) && !(is_copy && verdict == Verdict::right)) continue;
      ++outcome_.ours.broken;
      if (wrong.size() < kMostReported) wrong.push_back({i, rays[i], verdict, hits[i], expected[i]});
    }
    if (!wrong.empty()) report(scene, "not the first of the copies", std::move(wrong));
    return Done{};
  }

  // The witness's hits; none where nobody can tell in reasonable time.
  Result<std::vector<Hit>> testify(const StressScene& scene, const std::vector<Ray>& rays) const {
    std::vector<Hit> hits;
    if (run_.witness == StressWitness::embree && EmbreeWitness::available()) {
      const Result<EmbreeWitness> embree = EmbreeWitness::build(scene.mesh, {.build_threads = run_.threads});
      if (!embree) return embree.error();
      hits.resize(rays.size());
      embree->closest(rays, hits, run_.threads);
    } else if (!method().exhaustive && rays.size() <= kMostBruteForceTests / std::max<std::size_t>(1, scene.mesh.size())) {
      const Result<AnyAccel> brute = AnyAccel::build(scene.mesh, "brute/loop");
      if (!brute) return brute.error();
      hits.resize(rays.size());
      if (Status s = brute->closest(rays, hits, {.threads = run_.threads}); !s) return s.error();
    }
    return hits;
  }

  Status judge(const StressScene& scene, const std::vector<Ray>& rays, const std::vector<Hit>& hits) {
    const Result<std::vector<Hit>> witness = testify(scene, rays);
    if (!witness) return witness.error();
    const Judge judge(scene.mesh);
    CompareOptions options{
        .seed = run_.seed, .threads = run_.threads, .max_failures = kMostReported, .progress = run_.progress};
    if (witness->empty()) options.max_judged = kMostUnwitnessed;
    const Result<CheckResult> check = compare(judge, rays, hits, *witness, options);
    if (!check) return check.error();
    add(check->ours, outcome_.ours);
    outcome_.ours.unjudged += check->unjudged;
    if (run_.witness == StressWitness::embree && check->has_witness) {
      outcome_.robust.rays += rays.size();
      add(check->witness, outcome_.robust);
    }
    if (check->failures() > 0) report(scene, "wrong hits", repro_cases(*check, rays, hits, *witness));
    return Done{};
  }

  static void add(const Verdicts& verdicts, StressTally& tally) {
    tally.miss += verdicts.miss, tally.far += verdicts.far, tally.false_hit += verdicts.false_hit;
    tally.judged += verdicts.judged;
  }

  const StressCase& case_;
  const StressRun& run_;
  StressOutcome outcome_;
};

}  // namespace

StressTally& StressTally::operator+=(const StressTally& other) {
  rays += other.rays, leaks += other.leaks, miss += other.miss, far += other.far, false_hit += other.false_hit;
  broken += other.broken, judged += other.judged, unjudged += other.unjudged;
  return *this;
}

bool is_as_expected(const StressCase& one, const StressTally& tally) {
  return one.expected == Expected::measured ? tally.broken == 0 : tally.wrong() == 0;
}

Result<StressOutcome> run_case(const StressCase& one, const StressRun& run) {
  if (const Result<std::string> known = find_method(run.method); !known) return known.error();
  return one.scenes == nullptr ? run_leaks(one, run) : CaseRun(one, run).run();
}

}  // namespace accel::validation
