// What the SIMT model makes of the localized stage, for gl10.
#include <cstring>

#include "bench/paper_tables/gl10.h"
#include "libaccel/exec/simt.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/packet/localized_ray.h"
#include "libaccel/trace/bvh2_stack.h"

namespace accel::paper_tables::garanzha_loop {

namespace {

// Packets are left out so that about this many rays remain.
constexpr std::size_t kModelRays = 50'000;

std::size_t stride_of(const LocalizedBatch& batch) {
  std::size_t rays = 0;
  for (std::size_t i = 0; i < batch.count; ++i) rays += batch.packets[batch.active[i] + 1] - batch.packets[batch.active[i]];
  return rays / kModelRays + 1;
}

void take_packet(const LocalizedBatch& batch, std::size_t active, std::vector<Ray>& rays) {
  const std::uint32_t p = batch.active[active];
  rays.clear();
  for (std::uint32_t at = batch.packets[p]; at < batch.packets[p + 1]; ++at) rays.push_back(batch.rays[batch.ids[at]]);
}

template <Query kQuery>
Result<ModelProfiles> run(const LocalizedBatch& batch, const Bvh2View& view) {
  const auto agree = [](const Hit& a, const Hit& b) {
    return kQuery == Query::any ? a.valid() == b.valid() : std::memcmp(&a, &b, sizeof a) == 0;
  };
  ModelProfiles result;
  std::vector<Ray> rays;
  std::vector<Hit> hits, expected;
  const std::size_t stride = stride_of(batch);
  for (std::size_t i = 0; i < batch.count; i += stride) {
    take_packet(batch, i, rays);
    hits.resize(rays.size()), expected.resize(rays.size());
    const std::uint32_t first = batch.firsts[i];
    const PacketLeaves leaves{batch.nodes, batch.leaves, batch.places + first, batch.firsts[i + 1] - first};
    result.localized +=
        simulate_simt<LocalizedRay<Watertight, kQuery>>(leaves, rays, hits, {.schedule = SimtSchedule::if_while}, 1);
    result.stack += simulate_simt<Bvh2Stack<Watertight, kQuery>>(view, rays, expected, {}, 1);
    if (!std::equal(hits.begin(), hits.end(), expected.begin(), agree)) return Error{"the model's hits differ, which is a bug"};
  }
  return result;
}

}  // namespace

Result<ModelProfiles> run_model(Query query, const LocalizedBatch& batch, const Bvh2View& view) {
  return query == Query::any ? run<Query::any>(batch, view) : run<Query::closest>(batch, view);
}

}  // namespace accel::paper_tables::garanzha_loop
