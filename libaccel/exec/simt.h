// The SIMT model: 32 lanes in lockstep on the CPU, driving the same state machines as every other executor.
//
// The schedules are those of Aila and Laine 2009, "Understanding the Efficiency of Ray Traversal on GPUs" [AL09], section 3.
// One step runs one phase function for all lanes that are in its phase, while the others wait. "To the next node" in the
// paper's loops is descend or backtrack here: a lane that misses both children takes its next node from the stack without
// leaving the loop.
//
//   while-while   while a lane is at work: while a lane looks for a leaf: to the next node; then, while a lane has triangles
//                 left in its leaf: test one
//   if-if         while a lane is at work: to the next node, for lanes that look for a leaf; test one triangle, for lanes that
//                 have one
//   speculative   while-while, but a lane that has found a leaf postpones it and looks for another until all lanes hold one:
//                 section 3.2. Only for traversers that say how (SpeculativeTraverser); others run while-while
//   persistent    while-while, but lanes without work fetch rays from a queue: section 3.3. Deviation: lanes fetch one by one,
//                 once few enough are left at work, as in Aila, Laine and Karras 2012; in [AL09] a warp fetches 32 rays a time
//
//   if-while      while a lane is at work: to the next node, for lanes that look for a leaf; then, while a lane has triangles
//                 left in its leaf: test one. Not of [AL09]: it keeps lanes together that go through the same list of leaves,
//                 as in Garanzha and Loop 2010, Fig. 10 (packet/localized_ray.h)
//
// Hits are those of exec/cpu.h, bit for bit. A speculating lane visits nodes that a hit in its postponed leaf would have
// culled, which costs steps but no hit: the nearest hit does not depend on the order of tests, and any-hit meets the same
// leaves in the same order. One exception: a hit that rounding has moved out of its box (core/hit.h) may be found by
// speculation alone. The profile is the same for any number of threads: warps never share anything.
#pragma once

#include <tbb/combinable.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "libaccel/exec/cpu.h"
#include "libaccel/exec/simt_profile.h"
#include "libaccel/exec/simt_traffic.h"

namespace accel {

namespace detail {

// One warp, from its first ray to its last.
template <class Traverser>
class SimtWarp {
 public:
  SimtWarp(const typename Traverser::View& view, std::span<const Ray> rays, std::span<Hit> hits, const SimtOptions& options)
      : view_(view), rays_(rays), hits_(hits), options_(options) {}

  // Traces rays [begin, end), which this warp alone works off.
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

  const SimtProfile& profile() const { return profile_; }

 private:
  static constexpr bool kSpeculates = SpeculativeTraverser<Traverser>;
  static constexpr std::size_t kNoRay = ~std::size_t{0};

  struct Lane {
    std::size_t ray = kNoRay;  // index of the ray in hand
    Phase phase = Phase::done;
    bool holds_leaf = false;  // speculation: a leaf was found and its test postponed
    std::uint32_t leaf = 0;   // which one
    Hit hit;
    typename Traverser::State state;
    StackOf<Traverser> stack;

    bool searches() const { return phase == Phase::descend || phase == Phase::backtrack; }
    bool at_work() const { return phase != Phase::done || holds_leaf; }
  };

  // One outer iteration of the schedule's loop.
  void run_schedule() {
    switch (options_.schedule) {
      case SimtSchedule::if_if:
        step_to_next_node();
        step_intersect();
        return;
      case SimtSchedule::if_while:
        step_to_next_node();
        while (any([](const Lane& lane) { return lane.phase == Phase::intersect; })) step_intersect();
        return;
      case SimtSchedule::speculative_while_while:
        if constexpr (kSpeculates) return search_and_test_speculatively();
        [[fallthrough]];
      case SimtSchedule::while_while:
      case SimtSchedule::persistent_while_while:
        while (any([](const Lane& lane) { return lane.searches(); })) step_to_next_node();
        while (any([](const Lane& lane) { return lane.phase == Phase::intersect; })) step_intersect();
        return;
    }
  }

  void step_to_next_node() {
    step(profile_.descend, in(Phase::descend), [this](Lane& lane, LaneObserver& observer) {
      lane.phase = Traverser::descend(view_, rays_[lane.ray], lane.state, lane.hit, observer);
    });
    step(profile_.backtrack, in(Phase::backtrack), [this](Lane& lane, LaneObserver& observer) {
      lane.phase = Traverser::backtrack(view_, rays_[lane.ray], lane.state, lane.hit, observer);
    });
  }

  void step_intersect() {
    step(profile_.intersect, in(Phase::intersect), [this](Lane& lane, LaneObserver& observer) {
      lane.phase = Traverser::intersect(view_, rays_[lane.ray], lane.state, lane.hit, observer);
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
      lane.leaf = Traverser::leaf(lane.state), lane.holds_leaf = true;
      lane.phase = Traverser::kAfterLeaf;
      ++profile_.postponed_leaves;
    }
  }

  // One triangle of the leaf in hand. A lane whose search has ended in a second leaf takes that next.
  void step_held_leaves() {
    step(
        profile_.intersect, [](const Lane& lane) { return lane.holds_leaf; },
        [this](Lane& lane, LaneObserver& observer) {
          std::swap(Traverser::leaf(lane.state), lane.leaf);
          const Phase next = Traverser::intersect(view_, rays_[lane.ray], lane.state, lane.hit, observer);
          std::swap(Traverser::leaf(lane.state), lane.leaf);
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
        [this](Lane& lane, LaneObserver& observer) {
          lane.ray = next_++;
          requests_.add(Memory::ray, false, 0, lane.ray * sizeof(Ray), sizeof(Ray));
          attach_stack<Traverser>(lane.state, lane.stack);
          lane.phase = Traverser::begin(view_, rays_[lane.ray], lane.state, lane.hit, observer);
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
      LaneObserver observer(requests_, &lane.stack, sizeof lane.stack, l);
      run(lane, observer);
      ++active;
    }
    if (active == 0) return;
    steps += {1, static_cast<std::uint64_t>(active)};
    requests_.close(profile_);
  }

  static auto in(Phase phase) {
    return [phase](const Lane& lane) { return lane.phase == phase; };
  }

  template <class Predicate>
  bool any(const Predicate& predicate) const {
    return std::any_of(lanes_.begin(), lanes_.end(), predicate);
  }

  int lanes_at_work() const {
    return static_cast<int>(std::count_if(lanes_.begin(), lanes_.end(), [](const Lane& lane) { return lane.at_work(); }));
  }

  const typename Traverser::View& view_;
  std::span<const Ray> rays_;
  std::span<Hit> hits_;
  const SimtOptions& options_;
  std::size_t next_ = 0, end_ = 0;  // the rays that are left
  std::array<Lane, kWarpSize> lanes_;
  WarpRequests requests_;
  SimtProfile profile_;
};

}  // namespace detail

// Runs the rays on modelled warps: consecutive rays share a warp, 32 of them or, when persistent, options.rays_per_warp.
// hits[i] answers rays[i]; pass an empty span if the profile is all that is wanted. O(steps of the CPU executor), some ten
// times slower.
template <class Traverser>
SimtProfile simulate_simt(const typename Traverser::View& view, std::span<const Ray> rays, std::span<Hit> hits,
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
        for (std::size_t w = begin; w < end; ++w) {
          detail::SimtWarp<Traverser> warp(view, rays, hits, options);
          warp.run(w * rays_per_warp, std::min(rays.size(), (w + 1) * rays_per_warp));
          sums.local() += warp.profile();
        }
      },
      warps_per_task);
  SimtProfile total;
  sums.combine_each([&](const SimtProfile& profile) { total += profile; });
  return total;
}

}  // namespace accel
