// Build times of every builder of the registry, beside Embree's of low, medium and high quality in the same run.
//
// A group is a scene; its rows are the builders, a refit of the fast builder's tree, and Embree's qualities, of scenes that are
// not ROBUST: those have no high quality. Ratios are to medium quality. Scenes of instances have two more: instances that move,
// by ours and by Embree.
#include <benchmark/benchmark.h>

#include <memory>
#include <set>
#include <vector>

#include "bench/bench_main.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/registry/refit.h"
#include "validation/oracle/embree.h"

namespace accel::bench {
namespace {

void add_builder(const std::shared_ptr<Scene>& scene, const MethodInfo& method, int threads) {
  const auto row = [=](benchmark::State& state) {
    for (auto _ : state) {
      const Result<AnyAccel> accel = build(*scene, method, {.threads = threads});
      if (!accel) return state.SkipWithError(accel.message().c_str());
      state.counters["bytes"] = static_cast<double>(accel->size_bytes());
      state.counters["peak_bytes"] = static_cast<double>(accel->report().peak_bytes);
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scene->data.mesh.size()));
  };
  benchmark::RegisterBenchmark((scene->name + "|" + method.builder).c_str(), row)->Unit(benchmark::kMillisecond)->UseRealTime();
}

// A frame of a mesh that moves: the tree of the fast builder stays.
void add_refit(const std::shared_ptr<Scene>& scene, int threads) {
  const auto row = [=](benchmark::State& state) {
    const Result<AnyAccel> accel = AnyAccel::build(scene->data.mesh, "bvh8-fast/stream", {.threads = threads});
    if (!accel) return state.SkipWithError(accel.message().c_str());
    for (auto _ : state)
      if (const auto moved = refit(*accel, scene->data.mesh, {.threads = threads}); !moved)
        return state.SkipWithError(moved.message().c_str());
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scene->data.mesh.size()));
  };
  benchmark::RegisterBenchmark((scene->name + "|refit").c_str(), row)->Unit(benchmark::kMillisecond)->UseRealTime();
}

// A frame of a scene whose instances move, from where the caller knows their places on; they move to where they are.
void add_moves(const std::shared_ptr<Scene>& scene, int threads) {
  const InstancedMeshes& instanced = *scene->data.instances;
  const std::vector<Instance> places(instanced.instances().begin(), instanced.instances().end());
  const auto ours = [=](benchmark::State& state) {
    const auto accel = AnyAccel::build(*scene->data.instances, "bvh8-instances/stream", {.threads = threads});
    if (!accel) return state.SkipWithError(accel.message().c_str());
    for (auto _ : state) {
      const auto placed = scene->data.instances->with_instances(places);
      const auto moved = placed ? move_instances(*accel, *placed, {.threads = threads}) : placed.error();
      if (!moved) return state.SkipWithError(moved.message().c_str());
    }
  };
  benchmark::RegisterBenchmark((scene->name + "|move").c_str(), ours)->Unit(benchmark::kMillisecond)->UseRealTime();

  const auto embree = [=](benchmark::State& state) {
    auto built = validation::EmbreeWitness::build(*scene->data.instances,
                                                  {.mode = validation::EmbreeMode::fast, .build_threads = threads});
    if (!built) return state.SkipWithError(built.message().c_str());
    for (auto _ : state)
      if (const Status moved = built->move_instances(places); !moved) return state.SkipWithError(moved.message().c_str());
  };
  if (validation::EmbreeWitness::available())
    benchmark::RegisterBenchmark((scene->name + "|embree-move").c_str(), embree)->Unit(benchmark::kMillisecond)->UseRealTime();
}

// Without the copy of the mesh that Embree makes for itself: ours reads the caller's.
void add_embree(const std::shared_ptr<Scene>& scene, const char* name, validation::EmbreeQuality quality, int threads) {
  const auto row = [=](benchmark::State& state) {
    for (auto _ : state) {
      const auto embree = validation::EmbreeWitness::build(
          scene->data.mesh, {.mode = validation::EmbreeMode::fast, .quality = quality, .build_threads = threads});
      if (!embree) return state.SkipWithError(embree.message().c_str());
      state.SetIterationTime(embree->build_seconds());
      state.counters["bytes"] = static_cast<double>(embree->size_bytes());
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scene->data.mesh.size()));
  };
  benchmark::RegisterBenchmark((scene->name + "|" + name).c_str(), row)->Unit(benchmark::kMillisecond)->UseManualTime();
}

Status register_benchmarks(const Options& options) {
  for (const std::string& spec : options.scenes) {
    Result<Scene> loaded = load(spec);
    if (!loaded) return loaded.error();
    const auto scene = std::make_shared<Scene>(std::move(loaded).value());
    std::set<std::string> builders;
    for (const MethodInfo& method : methods())
      if (builders.insert(method.builder).second) add_builder(scene, method, options.threads);
    add_refit(scene, options.threads);
    if (scene->data.instances) add_moves(scene, options.threads);
    if (!validation::EmbreeWitness::available()) continue;
    add_embree(scene, kEmbreeRow, validation::EmbreeQuality::medium, options.threads);
    add_embree(scene, "embree-low", validation::EmbreeQuality::low, options.threads);
    add_embree(scene, "embree-high", validation::EmbreeQuality::high, options.threads);
  }
  return Done{};
}

}  // namespace
}  // namespace accel::bench

int main(int argc, char** argv) { return accel::bench::run(argc, argv, accel::bench::register_benchmarks); }
