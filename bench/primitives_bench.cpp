// The parallel primitives of packet/ beside a copy of the same array: how near they come to the bandwidth of the memory.
//
// bytes_per_second counts what each must read and write at least, once; --rays says how many elements there are.
#include <benchmark/benchmark.h>

#include <tbb/task_arena.h>

#include <memory>

#include "bench/bench_main.h"
#include "libaccel/core/counter_rng.h"
#include "libaccel/core/threads.h"
#include "libaccel/packet/cpu_primitives.h"

namespace accel::bench {
namespace {

constexpr const char* kCopyRow = "copy";

// Input and output of all primitives.
struct Arrays {
  explicit Arrays(std::size_t n) : values(n), out(n), ids(n), keys(n), sorted(n), flags(n) {
    CounterRng rng(1, n);
    for (std::size_t i = 0; i < n; ++i) {
      values[i] = rng.next_below(100), keys[i] = rng.next_u64() >> 32;
      flags[i] = rng.next_below(8) == 0 ? 1 : 0;
    }
    CpuPrimitives::for_each(n, [&](std::size_t i) { out[i] = ids[i] = 0, sorted[i] = 0; });
  }

  std::size_t size() const { return values.size(); }
  Buffer<std::uint32_t> values, out, ids;
  Buffer<std::uint64_t> keys, sorted;
  Buffer<std::uint8_t> flags;
};

// `bytes` an element are read and written.
template <class Body>
void add_row(const std::shared_ptr<Arrays>& arrays, int threads, const char* row, std::size_t bytes, const Body& body) {
  const auto run = [=](benchmark::State& state) {
    tbb::task_arena arena(arena_size(threads));
    for (auto _ : state) {
      arena.execute([&] { body(*arrays); });
      benchmark::ClobberMemory();
    }
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes * arrays->size()));
  };
  const std::string name = std::to_string(arrays->size()) + " elements|" + row;
  benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMillisecond)->UseRealTime();
}

Status register_benchmarks(const Options& options) {
  const auto arrays = std::make_shared<Arrays>(options.rays);
  const auto add = [&](const char* row, std::size_t bytes, const auto& body) {
    add_row(arrays, options.threads, row, bytes, body);
  };
  add(kCopyRow, 8, [](Arrays& a) { CpuPrimitives::for_each(a.size(), [&](std::size_t i) { a.out[i] = a.values[i]; }); });
  add("exclusive_scan", 8, [](Arrays& a) { CpuPrimitives::exclusive_scan(a.values.data(), a.size(), a.out.data()); });
  add("segmented_scan", 9,
      [](Arrays& a) { CpuPrimitives::inclusive_segmented_scan(a.values.data(), a.flags.data(), a.size(), a.out.data()); });
  add("compact", 2, [](Arrays& a) { CpuPrimitives::compact(a.flags.data(), a.size(), a.out.data()); });
  add("sort_pairs", 24, [](Arrays& a) {
    CpuPrimitives::for_each(a.size(),
                            [&](std::size_t i) { a.sorted[i] = a.keys[i], a.ids[i] = static_cast<std::uint32_t>(i); });
    CpuPrimitives::sort_pairs(a.sorted.data(), a.ids.data(), a.size());
  });
  return Done{};
}

}  // namespace
}  // namespace accel::bench

int main(int argc, char** argv) {
  return accel::bench::run(argc, argv, accel::bench::register_benchmarks, accel::bench::kCopyRow);
}
