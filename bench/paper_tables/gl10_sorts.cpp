// How long sorting takes, for gl10.
#include <tbb/task_arena.h>

#include <utility>

#include "bench/paper_tables/gl10.h"
#include "libaccel/core/threads.h"

namespace accel::paper_tables::garanzha_loop {

namespace {

using Hash = RayHash<std::uint32_t, 0>;

// The order of the rays. Compression tells how many chunks there were.
Buffer<std::uint32_t> sort(const Hash& hash, std::span<const Ray> rays, bool compresses, std::size_t& chunks) {
  Buffer<std::uint32_t> keys(rays.size());
  CpuPrimitives::for_each(rays.size(), [&](std::size_t i) { keys[i] = hash(rays[i]); });
  if (!compresses) return plain_sort<CpuPrimitives>(keys.data(), keys.size());
  auto order = csd_sort<CpuPrimitives>(std::as_const(keys).data(), keys.size());
  chunks = order.chunks;
  return order.ids;
}

}  // namespace

Result<SortTimes> measure_sorts(std::span<const Ray> rays, const Aabb& bounds, const Settings& settings) {
  const Hash hash = Hash::make(bounds, PipelineOptions{}.cell_fraction);
  SortTimes result{.rays = rays.size()};
  std::vector<double> csd, plain;
  tbb::task_arena arena(arena_size(settings.threads));
  const auto time = [&](bool compresses, Buffer<std::uint32_t>& ids, std::vector<double>& times) {
    const auto run = [&] { ids = sort(hash, rays, compresses, result.chunks); };
    return time_ms([&] { return arena.execute(run), Status(Done{}); }, times);
  };
  for (int turn = -1; turn < settings.repeat; ++turn) {
    Buffer<std::uint32_t> ours, theirs;
    if (const Status s = time(true, ours, csd); !s) return s.error();
    if (const Status s = time(false, theirs, plain); !s) return s.error();
    if (!std::equal(ours.begin(), ours.end(), theirs.begin(), theirs.end())) return Error{"sorts disagree, which is a bug"};
    if (turn < 0) csd.clear(), plain.clear();
  }
  result.csd_ms = median(csd), result.plain_ms = median(plain);
  return result;
}

}  // namespace accel::paper_tables::garanzha_loop
