// What the SIMT model makes of the localized stage, for gl10.
#include <cstring>

#include "bench/paper_tables/gl10.h"
#include "libaccel/exec/simt.h"
#include "libaccel/exec/simt_localized.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/packet/localized_ray.h"
#include "libaccel/trace/bvh2_stack.h"

namespace accel::paper_tables::garanzha_loop {

namespace {

// Packets are left out so that about this many rays remain.
constexpr std::size_t kModelRays = 50'000;
// That a warp with queues works off: those of a large batch on a large device.
constexpr std::uint32_t kRaysPerWarp = 1024;

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

// The steps of SimtSchedule::if_while, to see what lanes do that are not at work.
template <Query kQuery>
class LaneUses {
  using Traverser = LocalizedRay<Watertight, kQuery>;

 public:
  LaneUses(LaneUse& boxes, LaneUse& triangles) : boxes_(boxes), triangles_(triangles) {}

  void add(const PacketLeaves& leaves, std::span<const Ray> rays) {
    for (std::size_t first = 0; first < rays.size(); first += kWarpSize)
      add_warp(leaves, rays.subspan(first, std::min<std::size_t>(kWarpSize, rays.size() - first)));
  }

 private:
  struct Lane {
    const Ray* ray;
    typename Traverser::State state;
    Hit hit;
    Phase phase;
  };

  void add_warp(const PacketLeaves& leaves, std::span<const Ray> rays) {
    lanes_.resize(rays.size());
    for (std::size_t l = 0; l < rays.size(); ++l) {
      lanes_[l].ray = &rays[l];
      lanes_[l].phase = Traverser::begin(leaves, rays[l], lanes_[l].state, lanes_[l].hit, nobody_);
    }
    while (step(leaves, Phase::descend, boxes_))
      while (step(leaves, Phase::intersect, triangles_)) {
      }
  }

  // False if no lane is in the phase.
  bool step(const PacketLeaves& leaves, Phase phase, LaneUse& use) {
    const auto in_phase = [phase](const Lane& lane) { return lane.phase == phase; };
    if (std::none_of(lanes_.begin(), lanes_.end(), in_phase)) return false;
    use.steps += 1, use.have_no_ray += kWarpSize - lanes_.size();
    for (Lane& lane : lanes_) {
      const bool is_answered = kQuery == Query::any && lane.hit.valid();
      ++(in_phase(lane) ? use.at_work : is_answered ? use.are_answered : use.have_missed_box);
      if (!in_phase(lane)) continue;
      const auto run =
          phase == Phase::descend ? Traverser::template descend<NullObserver> : Traverser::template intersect<NullObserver>;
      lane.phase = run(leaves, *lane.ray, lane.state, lane.hit, nobody_);
    }
    return true;
  }

  LaneUse &boxes_, &triangles_;
  std::vector<Lane> lanes_;
  NullObserver nobody_;
};

bool same_steps(const LaneUse& use, const SimtProfile::PhaseSteps& phase) {
  return use.steps == phase.steps && use.at_work == phase.active_lanes;
}

// All packets that are modelled, for warps that take rays of any.
struct Tasks {
  std::vector<Ray> rays;
  std::vector<LocalizedTask> tasks;
  std::vector<Hit> expected;

  void add(std::size_t active, const std::vector<Ray>& packet, const std::vector<Hit>& hits) {
    for (const Ray& ray : packet) {
      tasks.push_back({static_cast<std::uint32_t>(rays.size()), static_cast<std::uint32_t>(active)});
      rays.push_back(ray);
    }
    expected.insert(expected.end(), hits.begin(), hits.end());
  }
  LocalizedTasks view(const LocalizedBatch& batch) const {
    return {batch.nodes,
            batch.leaves,
            rays.data(),
            tasks.data(),
            batch.firsts,
            batch.places,
            static_cast<std::uint32_t>(tasks.size())};
  }
};

template <Query kQuery>
bool agree(const std::vector<Hit>& hits, const std::vector<Hit>& expected) {
  return std::equal(hits.begin(), hits.end(), expected.begin(), expected.end(), [](const Hit& a, const Hit& b) {
    return kQuery == Query::any ? a.valid() == b.valid() : std::memcmp(&a, &b, sizeof a) == 0;
  });
}

template <Query kQuery>
Result<ModelProfiles> run(const LocalizedBatch& batch, const Bvh2View& view) {
  ModelProfiles result;
  LaneUses<kQuery> uses(result.boxes, result.triangles);
  Tasks tasks;
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
    uses.add(leaves, rays);
    result.stack += simulate_simt<Bvh2Stack<Watertight, kQuery>>(view, rays, expected, {}, 1);
    if (!agree<kQuery>(hits, expected)) return Error{"the model's hits differ, which is a bug"};
    tasks.add(i, rays, expected);
  }
  if (!same_steps(result.boxes, result.localized.descend) || !same_steps(result.triangles, result.localized.intersect))
    return Error{"lanes do not add up, which is a bug"};
  hits.resize(tasks.rays.size());
  result.queues = simulate_localized<Watertight, kQuery, kLocalizedRaysInHand>(tasks.view(batch), hits.data(), kRaysPerWarp);
  if (!agree<kQuery>(hits, tasks.expected)) return Error{"the hits of warps with queues differ, which is a bug"};
  return result;
}

}  // namespace

Result<ModelProfiles> run_model(Query query, const LocalizedBatch& batch, const Bvh2View& view) {
  return query == Query::any ? run<Query::any>(batch, view) : run<Query::closest>(batch, view);
}

}  // namespace accel::paper_tables::garanzha_loop
