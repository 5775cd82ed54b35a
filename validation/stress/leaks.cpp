#include "validation/stress/leaks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "libaccel/exec/cpu.h"
#include "libaccel/rays/aim.h"
#include "libaccel/registry/any_accel.h"
#include "validation/oracle/embree.h"
#include "validation/stress/closed_meshes.h"

namespace accel::validation {
namespace {

constexpr std::size_t kChunk = 1 << 17;  // rays in memory at once; Embree's fast mode traces the first of each mesh
constexpr double kScales[] = {1e-3, 1, 1e3};
constexpr double kSampleShare = 1e-3;
constexpr std::uint64_t kLeastSample = 50;  // of each mesh
constexpr float kSlack = 0x1p-10f;          // by how much a t may differ before somebody is asked
constexpr std::size_t kMostLeaksReported = 8;

// A closed mesh at its place, and the rays at it.
struct PlacedMesh {
  const ClosedMesh* shape;
  Placement placement;
  TriangleMesh mesh;
  std::uint64_t seed;

  static bool is_inside(std::uint64_t i) { return i / 4 % 2 == 0; }

  Ray ray(std::uint64_t i) const {
    CounterRng rng(seed, i);
    const Triangle triangle = mesh.triangle(rng.next_below(static_cast<std::uint32_t>(mesh.size())));
    Vec3 target = i % 2 == 0 ? (&triangle.v0)[rng.next_below(3)] : on_edge(triangle, rng);
    if (i / 2 % 2 != 0) target = beside(target, rng);
    return aim(placement(is_inside(i) ? shape->inside(rng) : shape->outside(rng)).to_float(), target);
  }

 private:
  static Vec3 on_edge(const Triangle& triangle, CounterRng& rng) {
    const std::uint32_t from = rng.next_below(3);
    const Vec3d a((&triangle.v0)[from]), b((&triangle.v0)[(from + 1) % 3]);
    const double share = rng.next_below(2) != 0 ? rng.next_double() : (1 + rng.next_below(7)) / 8.0;
    return (a * (1 - share) + b * share).to_float();
  }
  static Vec3 beside(Vec3 p, CounterRng& rng) {
    for (int a = 0; a < 3; ++a) {
      const std::uint32_t side = rng.next_below(3);
      if (side != 0) p[a] = side == 1 ? next_up(p[a]) : next_down(p[a]);
    }
    return p;
  }
};

// The rays of a chunk, and who answered what.
struct Chunk {
  std::uint64_t first = 0;  // the number of its first ray
  std::vector<Ray> rays;
  std::vector<Hit> ours, robust, fast;  // Embree's are empty where it did not trace
};

class LeakRun {
 public:
  LeakRun(const StressCase& one, const StressRun& run) : case_(one), run_(run) {}

  Result<StressOutcome> run() {
    const std::vector<ClosedMesh> shapes = closed_meshes(run_.size == SceneSize::small ? 200 : 10'000, run_.seed);
    const std::size_t count = shapes.size() * std::size(kScales);
    std::size_t number = 0;
    for (const ClosedMesh& shape : shapes)
      for (const double scale : kScales) {
        const Placement placement{scale, case_.offset};
        const PlacedMesh mesh{&shape, placement, placed(shape.mesh, placement), run_.seed * 1000 + number};
        const Status done =
            trace(mesh, (run_.rays + count - 1) / count, static_cast<double>(number) / static_cast<double>(count));
        if (!done) return done.error();
        ++number;
      }
    return outcome_;
  }

 private:
  struct Engines {
    AnyAccel ours;
    std::optional<EmbreeWitness> robust, fast;
    Judge judge;
  };

  static Result<Engines> build(const TriangleMesh& mesh, const StressRun& run) {
    Result<AnyAccel> ours = AnyAccel::build(mesh, run.method, {.threads = run.threads});
    if (!ours) return ours.error();
    Engines engines{*std::move(ours), std::nullopt, std::nullopt, Judge(mesh)};
    if (run.witness != StressWitness::embree || !EmbreeWitness::available()) return engines;
    for (const EmbreeMode mode : {EmbreeMode::robust, EmbreeMode::fast}) {
      Result<EmbreeWitness> embree = EmbreeWitness::build(mesh, {.mode = mode, .build_threads = run.threads});
      if (!embree) return embree.error();
      (mode == EmbreeMode::robust ? engines.robust : engines.fast) = *std::move(embree);
    }
    return engines;
  }

  Status trace(const PlacedMesh& mesh, std::uint64_t count, double fraction) {
    const Result<Engines> engines = build(mesh.mesh, run_);
    if (!engines) return engines.error();
    sample_share_ = std::max(kSampleShare, std::min(1.0, static_cast<double>(kLeastSample) / static_cast<double>(count)));
    for (std::uint64_t first = 0; first < count; first += kChunk) {
      if (run_.progress && !run_.progress(case_.name, fraction)) return Error{std::string(kInterrupted)};
      if (Status s = make_chunk(mesh, *engines, first, std::min<std::uint64_t>(kChunk, count - first)); !s) return s;
      examine(mesh, engines->judge, chunk_.ours, outcome_.ours, true);
      if (!chunk_.robust.empty()) examine(mesh, engines->judge, chunk_.robust, outcome_.robust, false);
      if (!chunk_.fast.empty()) examine(mesh, engines->judge, chunk_.fast, outcome_.fast, false);
    }
    return Done{};
  }

  Status make_chunk(const PlacedMesh& mesh, const Engines& engines, std::uint64_t first, std::size_t size) {
    chunk_.first = first;
    chunk_.rays.resize(size), chunk_.ours.resize(size);
    for_each_block(size, run_.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) chunk_.rays[i] = mesh.ray(first + i);
    });
    chunk_.robust.resize(engines.robust ? size : 0), chunk_.fast.resize(engines.fast && first == 0 ? size : 0);
    if (engines.robust) engines.robust->closest(chunk_.rays, chunk_.robust, run_.threads);
    if (!chunk_.fast.empty()) engines.fast->closest(chunk_.rays, chunk_.fast, run_.threads);
    return engines.ours.closest(chunk_.rays, chunk_.ours, {.threads = run_.threads});
  }

  // Whether an answer is one that a closed mesh does not explain.
  bool is_suspicious(std::size_t i, const Hit& hit) const {
    if (!hit.valid() || !(hit.t <= 1 + kSlack)) return true;
    const Hit other = chunk_.robust.empty() ? hit : chunk_.robust[i];
    return !other.valid() || !(std::fabs(hit.t - other.t) <= kSlack * std::fabs(other.t));
  }
  bool is_in_sample(std::size_t i) const { return CounterRng(run_.seed, chunk_.first + i, 9).next_double() < sample_share_; }

  void examine(const PlacedMesh& mesh, const Judge& judge, const std::vector<Hit>& hits, StressTally& tally, bool ours) {
    std::vector<std::size_t> asked;
    for (std::size_t i = 0; i < hits.size(); ++i)
      if (is_suspicious(i, hits[i]) || is_in_sample(i)) asked.push_back(i);
    std::vector<Verdict> verdicts(asked.size());
    const auto decide = [&](std::size_t begin, std::size_t end) {
      for (std::size_t a = begin; a < end; ++a) {
        const Ray& ray = chunk_.rays[asked[a]];
        verdicts[a] = judge.judge(ray, hits[asked[a]], judge.oracle().closest(ray));
      }
    };
    for_each_block(asked.size(), run_.threads, decide, 64);

    tally.rays += hits.size(), tally.judged += asked.size();
    std::vector<ReproCase> wrong;
    for (std::size_t a = 0; a < asked.size(); ++a) {
      const std::size_t i = asked[a];
      const bool leaks = count(verdicts[a], PlacedMesh::is_inside(chunk_.first + i), hits[i].valid(), tally);
      if ((!leaks && !is_failure(verdicts[a])) || wrong.size() == kMostLeaksReported) continue;
      wrong.push_back({i, chunk_.rays[i], verdicts[a], hits[i], std::nullopt});
      if (!chunk_.robust.empty()) wrong.back().witness = chunk_.robust[i];
    }
    if (ours && !wrong.empty() && run_.on_failure && case_.expected != Expected::measured)
      run_.on_failure({case_.name, name_of(mesh), "leaks or wrong hits", &mesh.mesh, std::move(wrong)});
  }

  // Adds a verdict; returns whether the ray leaks.
  static bool count(Verdict verdict, bool inside, bool hits, StressTally& tally) {
    tally.miss += verdict == Verdict::miss, tally.far += verdict == Verdict::far;
    tally.false_hit += verdict == Verdict::false_hit;
    const bool leaks = inside ? !hits : verdict == Verdict::miss || verdict == Verdict::far;
    tally.leaks += leaks;
    return leaks;
  }

  static std::string name_of(const PlacedMesh& mesh) {
    return mesh.shape->name + " times " + std::to_string(mesh.placement.scale) + " at " + std::to_string(mesh.placement.offset);
  }

  const StressCase& case_;
  const StressRun& run_;
  StressOutcome outcome_;
  Chunk chunk_;
  double sample_share_ = kSampleShare;
};

}  // namespace

Result<StressOutcome> run_leaks(const StressCase& one, const StressRun& run) { return LeakRun(one, run).run(); }

}  // namespace accel::validation
