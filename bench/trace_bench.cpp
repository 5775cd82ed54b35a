// Rays per second of every method, beside Embree's on the same rays in the same run.
//
// A group is a scene and a ray kind; its rows are the methods, the recommended one by a call for each ray, too, the two-box BVH
// with scalar box tests, and Embree through single-ray calls in its fast mode, which ratios refer to, and in its robust one.
// Closest or any hit, as renderers ask it of the kind.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <memory>

#include "bench/bench_main.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/trace/bvh2_stack.h"
#include "validation/oracle/embree.h"

namespace accel::bench {
namespace {

constexpr RayKind kKinds[] = {RayKind::primary, RayKind::shadow, RayKind::diffuse, RayKind::random, RayKind::edge};

// Brute force is there to be right, not fast: it gets small scenes only.
constexpr std::size_t kMostTrianglesForExhaustive = 2000;

// Everything that the rows of a scene share; they hold it alive.
struct Subject {
  Scene scene;
  std::vector<AnyAccel> methods;
  std::vector<std::unique_ptr<validation::EmbreeWitness>> embree;  // fast, robust; or none
};

Result<std::shared_ptr<Subject>> prepare(const std::string& spec) {
  Result<Scene> scene = load(spec);
  if (!scene) return scene.error();
  auto subject = std::make_shared<Subject>();
  subject->scene = std::move(scene).value();
  const TriangleMesh& mesh = subject->scene.data.mesh;
  for (const MethodInfo& method : methods()) {
    if (method.exhaustive && mesh.size() > kMostTrianglesForExhaustive) continue;
    // Methods of one builder share the structure.
    const auto sibling = std::find_if(subject->methods.begin(), subject->methods.end(),
                                      [&](const AnyAccel& other) { return other.method().builder == method.builder; });
    Result<AnyAccel> accel =
        sibling != subject->methods.end() ? sibling->with_method(method.name) : build(subject->scene, method);
    if (!accel) return accel.error();
    subject->methods.push_back(std::move(accel).value());
  }
  if (!validation::EmbreeWitness::available()) return subject;
  for (const validation::EmbreeMode mode : {validation::EmbreeMode::fast, validation::EmbreeMode::robust}) {
    Result<validation::EmbreeWitness> embree = validation::EmbreeWitness::build(mesh, {.mode = mode});
    if (!embree) return embree.error();
    subject->embree.push_back(std::make_unique<validation::EmbreeWitness>(std::move(embree).value()));
  }
  return subject;
}

struct RayBatch {
  RaySet set;
  Query query;
  std::vector<Hit> hits;
  std::vector<std::uint8_t> occluded;
};

// Registers a row. `closest` and `occluded` answer a batch.
template <class Closest, class Occluded>
void add_row(const std::string& name, const std::shared_ptr<RayBatch>& batch, const Closest& closest,
             const Occluded& occluded) {
  const auto row = [=](benchmark::State& state) {
    for (auto _ : state) {
      if (batch->query == Query::closest)
        closest(batch->set.rays.span(), std::span(batch->hits));
      else
        occluded(batch->set.rays.span(), std::span(batch->occluded));
      benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(batch->set.size()));
  };
  benchmark::RegisterBenchmark(name.c_str(), row)->Unit(benchmark::kMillisecond)->UseRealTime();
}

// By a call for each ray, in one thread.
void add_single_rays(const std::string& name, const AnyAccel& accel, const std::shared_ptr<RayBatch>& batch) {
  add_row(
      name, batch,
      [=](std::span<const Ray> rays, std::span<Hit> hits) {
        for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = accel.closest(rays[i]);
      },
      [=](std::span<const Ray> rays, std::span<std::uint8_t> out) {
        for (std::size_t i = 0; i < rays.size(); ++i) out[i] = accel.occluded(rays[i]) ? 1 : 0;
      });
}

// The method's traversal without SIMD in its steps: what traversals whose steps are scalar are to be compared with.
void add_scalar_boxes(const std::string& name, const AnyAccel& accel, const std::shared_ptr<RayBatch>& batch, int threads) {
  add_row(
      name, batch,
      [=](std::span<const Ray> rays, std::span<Hit> hits) {
        using Traverser = Bvh2StackWith<Watertight, Query::closest, true, ScalarBoxPairTest>;
        trace_closest<Traverser>(accel.structure().get_if<Bvh2>()->view(), rays, hits, threads);
      },
      [=](std::span<const Ray> rays, std::span<std::uint8_t> out) {
        using Traverser = Bvh2StackWith<Watertight, Query::any, true, ScalarBoxPairTest>;
        trace_any<Traverser>(accel.structure().get_if<Bvh2>()->view(), rays, out, threads);
      });
}

void add_group(const std::string& group, const std::shared_ptr<Subject>& subject, const std::shared_ptr<RayBatch>& batch,
               int threads) {
  using Rays = std::span<const Ray>;
  for (const AnyAccel& accel : subject->methods)
    add_row(
        group + "|" + accel.method().name, batch,
        [=](Rays rays, std::span<Hit> hits) { benchmark::DoNotOptimize(accel.closest(rays, hits, {.threads = threads}).ok()); },
        [=](Rays rays, std::span<std::uint8_t> out) {
          benchmark::DoNotOptimize(accel.occluded(rays, out, {.threads = threads}).ok());
        });
  for (const AnyAccel& accel : subject->methods) {
    const std::string& method = accel.method().name;
    if (method == best_method()) add_single_rays(group + "|" + method + "-single", accel, batch);
    if (method == "sbvh/stack") add_scalar_boxes(group + "|" + method + "-scalar", accel, batch, threads);
  }
  for (const auto& owned : subject->embree) {
    const validation::EmbreeWitness* embree = owned.get();
    const bool fast = embree->options().mode == validation::EmbreeMode::fast;
    add_row(
        group + "|" + (fast ? kEmbreeRow : "embree-robust"), batch,
        [subject, embree, threads](Rays rays, std::span<Hit> hits) { embree->closest(rays, hits, threads); },
        [subject, embree, threads](Rays rays, std::span<std::uint8_t> out) { embree->occluded(rays, out, threads); });
  }
}

Status register_benchmarks(const Options& options) {
  for (const std::string& spec : options.scenes) {
    const auto subject = prepare(spec);
    if (!subject) return subject.error();
    for (const RayKind kind : kKinds) {
      Result<RaySet> rays = make_rays((*subject)->scene, kind, options.rays);
      if (!rays) return rays.error();
      auto batch = std::make_shared<RayBatch>();
      batch->query = info(kind).query;
      batch->hits.resize(rays->size()), batch->occluded.resize(rays->size());
      batch->set = std::move(rays).value();
      if (batch->set.size() > 0)
        add_group((*subject)->scene.name + "/" + std::string(info(kind).name), *subject, batch, options.threads);
    }
  }
  return Done{};
}

}  // namespace
}  // namespace accel::bench

int main(int argc, char** argv) { return accel::bench::run(argc, argv, accel::bench::register_benchmarks); }
