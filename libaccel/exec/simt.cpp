#include "libaccel/exec/simt.h"

#include <tbb/combinable.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "libaccel/exec/cpu.h"
#include "libaccel/exec/simt_traffic.h"

namespace accel {

namespace {

// One warp at a time, from its first ray to its last.
class SimtWarp {
 public:
  SimtWarp(const AnyTraverser::View& view, std::span<const Ray> rays, std::span<Hit> hits, const SimtOptions& options)
      : view_(view), rays_(rays), hits_(hits), options_(options), states_(view, kWarpSize) {
    for (int l = 0; l < kWarpSize; ++l) lanes_[l].state = states_[l];
  }

  // Traces rays [begin, end), which one warp alone works off.
  void run(std::size_t begin, std::size_t end) {
    next_ = begin, end_ = end;
    const bool persistent = options_.schedule == SimtSchedule::persistent_while_while;
    const int fetch_below = persistent ? std::clamp(static_cast<int>(options_.fetch_below), 1, kWarpSize) : 1;
    profile_.warps += 1;
    profile_.rays += end - begin;
    while (next_ < end_ || lanes_at_work() > 0) {
      if (next_ < end_ && lanes_at_work() < fetch_below) fetch();
      run_schedule();
    }
    retire();
  }

  // Of all warps so far.
  const SimtProfile& profile() const { return profile_; }

 private:
  static constexpr std::size_t kNoRay = ~std::size_t{0};

  struct Lane {
    std::size_t ray = kNoRay;  // index of the ray in hand
    Phase phase = Phase::done;
    bool holds_leaf = false;  // speculation: a leaf was found and its test postponed
    std::uint32_t leaf = 0;   // which one
    Hit hit;
    AnyTraverser::State state;

    bool searches() const { return phase == Phase::descend || phase == Phase::backtrack; }
    bool at_work() const { return phase != Phase::done || holds_leaf; }
  };

  static auto in(Phase phase) {
    return [phase](const Lane& lane) { return lane.phase == phase; };
  }

  // One outer iteration of the schedule's loop.
  void run_schedule() {
    switch (options_.schedule) {
      case SimtSchedule::if_if:
        step_to_next_node();
        step_intersect();
        return;
      case SimtSchedule::if_while:
        step_to_next_node();
        while (any(in(Phase::intersect))) step_intersect();
        return;
      case SimtSchedule::speculative_while_while:
        if (view_.leaf != nullptr) return search_and_test_speculatively();
        [[fallthrough]];
      case SimtSchedule::while_while:
      case SimtSchedule::persistent_while_while:
        while (any([](const Lane& lane) { return lane.searches(); })) step_to_next_node();
        while (any(in(Phase::intersect))) step_intersect();
        return;
    }
  }

  void step_to_next_node() {
    step(profile_.descend, in(Phase::descend), [this](Lane& lane, StepObserver& observer) {
      lane.phase = AnyTraverser::descend(view_, rays_[lane.ray], lane.state, lane.hit, observer);
    });
    step(profile_.backtrack, in(Phase::backtrack), [this](Lane& lane, StepObserver& observer) {
      lane.phase = AnyTraverser::backtrack(view_, rays_[lane.ray], lane.state, lane.hit, observer);
    });
  }

  void step_intersect() {
    step(profile_.intersect, in(Phase::intersect), [this](Lane& lane, StepObserver& observer) {
      lane.phase = AnyTraverser::intersect(view_, rays_[lane.ray], lane.state, lane.hit, observer);
    });
  }

  // [AL09] section 3.2: search until every lane at work holds a leaf (or has no nodes left), then test all leaves that were
  // found.
  void search_and_test_speculatively() {
    hold_leaves();
    while (any([](const Lane& lane) { return lane.searches() && !lane.holds_leaf; })) {
      step_to_next_node();
      hold_leaves();
    }
    while (any([](const Lane& lane) { return lane.holds_leaf; })) step_held_leaves();
  }

  // A lane that stands in a leaf with empty hands takes the leaf and goes on as if it had been tested without a hit.
  void hold_leaves() {
    for (Lane& lane : lanes_) {
      if (lane.phase != Phase::intersect || lane.holds_leaf) continue;
      lane.leaf = view_.leaf(lane.state), lane.holds_leaf = true;
      lane.phase = view_.after_leaf;
      ++profile_.postponed_leaves;
    }
  }

  // One triangle of the leaf in hand. A lane whose search has ended in a second leaf takes that next.
  void step_held_leaves() {
    step(
        profile_.intersect, [](const Lane& lane) { return lane.holds_leaf; },
        [this](Lane& lane, StepObserver& observer) {
          std::swap(view_.leaf(lane.state), lane.leaf);
          const Phase next = AnyTraverser::intersect(view_, rays_[lane.ray], lane.state, lane.hit, observer);
          std::swap(view_.leaf(lane.state), lane.leaf);
          lane.holds_leaf = next == Phase::intersect;
          if (next == Phase::done) lane.phase = Phase::done;
        });
    hold_leaves();
  }

  // Lanes without work write their hits and take the next rays.
  void fetch() {
    retire();
    step(
        profile_.fetch, [this](const Lane& lane) { return lane.ray == kNoRay && next_ < end_; },
        [this](Lane& lane, StepObserver& observer) {
          lane.ray = next_++;
          requests_.add(Memory::ray, false, 0, lane.ray * sizeof(Ray), sizeof(Ray));
          lane.phase = AnyTraverser::begin(view_, rays_[lane.ray], lane.state, lane.hit, observer);
        });
  }

  void retire() {
    for (Lane& lane : lanes_) {
      if (lane.ray == kNoRay || lane.at_work()) continue;
      finish_hit(lane.hit);
      if (!hits_.empty()) hits_[lane.ray] = lane.hit;
      requests_.add(Memory::ray, true, 0, lane.ray * sizeof(Hit), sizeof(Hit));
      lane.ray = kNoRay;
    }
    requests_.close(profile_);
  }

  // One instruction of the model: `run` for every lane that takes part. Nothing is issued when there is none.
  template <class TakesPart, class Run>
  void step(SimtProfile::PhaseSteps& steps, const TakesPart& takes_part, const Run& run) {
    int active = 0;
    for (int l = 0; l < kWarpSize; ++l) {
      Lane& lane = lanes_[l];
      if (!takes_part(lane)) continue;
      LaneObserver requests(requests_, lane.state.stack, view_.stack_bytes, l);
      StepObserver observer;
      observer.lane = &requests;
      run(lane, observer);
      ++active;
    }
    if (active == 0) return;
    steps += {1, static_cast<std::uint64_t>(active)};
    requests_.close(profile_);
  }

  template <class Predicate>
  bool any(const Predicate& predicate) const {
    return std::any_of(lanes_.begin(), lanes_.end(), predicate);
  }

  int lanes_at_work() const {
    return static_cast<int>(std::count_if(lanes_.begin(), lanes_.end(), [](const Lane& lane) { return lane.at_work(); }));
  }

  const AnyTraverser::View& view_;
  std::span<const Ray> rays_;
  std::span<Hit> hits_;
  const SimtOptions& options_;
  std::size_t next_ = 0, end_ = 0;  // the rays that are left
  AnyStates states_;
  std::array<Lane, kWarpSize> lanes_;
  WarpRequests requests_;
  SimtProfile profile_;
};

}  // namespace

SimtProfile simulate_simt(const AnyTraverser::View& view, std::span<const Ray> rays, std::span<Hit> hits,
                          const SimtOptions& options, int threads) {
  ACCEL_ASSERT(hits.empty() || hits.size() == rays.size());
  const bool persistent = options.schedule == SimtSchedule::persistent_while_while;
  const std::size_t rays_per_warp = persistent ? std::max<std::size_t>(options.rays_per_warp, kWarpSize) : kWarpSize;
  const std::size_t warps = (rays.size() + rays_per_warp - 1) / rays_per_warp;

  tbb::combinable<SimtProfile> sums;
  const std::size_t warps_per_task = std::max<std::size_t>(1, kRaysPerTask / rays_per_warp);
  for_each_block(
      warps, threads,
      [&](std::size_t begin, std::size_t end) {
        SimtWarp warp(view, rays, hits, options);
        for (std::size_t w = begin; w < end; ++w) warp.run(w * rays_per_warp, std::min(rays.size(), (w + 1) * rays_per_warp));
        sums.local() += warp.profile();
      },
      warps_per_task);
  SimtProfile total;
  sums.combine_each([&](const SimtProfile& profile) { total += profile; });
  return total;
}

}  // namespace accel
