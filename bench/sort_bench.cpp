// Sorting rays by their hash values: compression, sorting and decompression against the plain radix sort, hashing included.
//
// Garanzha and Loop 2010, section 5.2, report about twice the speed for the soft-shadow rays of a picture, of 32 bits of their
// origins only. A group is a scene, a kind of rays and what is hashed of them.
#include <benchmark/benchmark.h>

#include <tbb/task_arena.h>

#include <memory>

#include "bench/bench_main.h"
#include "libaccel/core/threads.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/packet/cpu_primitives.h"
#include "libaccel/packet/csd_sort.h"
#include "libaccel/packet/ray_hash.h"

namespace accel::bench {
namespace {

constexpr const char* kPlainRow = "radix";
constexpr float kCellFraction = 0.004f;  // section 5.1
constexpr RayKind kKinds[] = {RayKind::primary, RayKind::soft_shadow, RayKind::diffuse};

template <class Key>
Buffer<Key> hash_values(const RaySet& set, const RayHash<Key>& hash) {
  Buffer<Key> values(set.size());
  CpuPrimitives::for_each(set.size(), [&](std::size_t i) { values[i] = hash(set.rays[i]); });
  return values;
}

template <class Key>
void sort_plainly(const RaySet& set, const RayHash<Key>& hash) {
  Buffer<Key> values = hash_values(set, hash);
  const auto ids = plain_sort<CpuPrimitives>(values.data(), values.size());
  benchmark::DoNotOptimize(ids.data());
}

template <class Key>
std::size_t sort_compressed(const RaySet& set, const RayHash<Key>& hash) {
  const Buffer<Key> values = hash_values(set, hash);
  const auto order = csd_sort<CpuPrimitives>(values.data(), values.size());
  benchmark::DoNotOptimize(order.ids.data());
  return order.chunks;
}

template <class Key>
void add_group(const std::string& group, const std::shared_ptr<RaySet>& set, const RayHash<Key>& hash, int threads) {
  const auto add = [&](const char* row, auto sort) {
    const auto run = [=](benchmark::State& state) {
      tbb::task_arena arena(arena_size(threads));
      for (auto _ : state) arena.execute([&] { sort(state); });
      state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(set->size()));
    };
    benchmark::RegisterBenchmark((group + "|" + row).c_str(), run)->Unit(benchmark::kMillisecond)->UseRealTime();
  };
  add(kPlainRow, [=](benchmark::State&) { sort_plainly(*set, hash); });
  add("csd", [=](benchmark::State& state) {
    state.counters["rays_per_chunk"] = static_cast<double>(set->size()) / static_cast<double>(sort_compressed(*set, hash));
  });
}

Status register_benchmarks(const Options& options) {
  for (const std::string& spec : options.scenes) {
    const Result<Scene> scene = load(spec);
    if (!scene) return scene.error();
    const SceneData& data = scene->data;
    const Aabb bounds = (data.instances ? mesh_facts(*data.instances) : mesh_facts(data.mesh)).bounds;
    for (const RayKind kind : kKinds) {
      Result<RaySet> rays = make_rays(*scene, kind, options.rays);
      if (!rays) return rays.error();
      const auto set = std::make_shared<RaySet>(std::move(rays).value());
      if (set->size() == 0) continue;
      const std::string group = scene->name + "/" + std::string(info(kind).name);
      add_group(group + "/origins, 32 bits", set, RayHash<std::uint32_t>::make(bounds, kCellFraction, true), options.threads);
      add_group(group + "/rays, 64 bits", set, RayHash<std::uint64_t>::make(bounds, kCellFraction), options.threads);
    }
  }
  return Done{};
}

}  // namespace
}  // namespace accel::bench

int main(int argc, char** argv) {
  return accel::bench::run(argc, argv, accel::bench::register_benchmarks, accel::bench::kPlainRow);
}
