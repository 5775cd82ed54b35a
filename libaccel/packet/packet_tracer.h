// Traces batches of rays as packets on CPUs, each batch by one thread, in blocks that fit the caches: Garanzha and Loop 2010,
// "Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray Tracing" [GL10], section 3.
//
// Rays that follow each other make packets (packet/packet_ranges.h), packets frustums (packet/frustum.h), frustums go through
// an Octo-BVH together (packet/breadth_first.h), and rays are tested against the leaves that their frustum meets
// (packet/localized.h).
//
// Order. [GL10] sorts all rays. Here that is done where it makes narrower frustums, as for a picture's rows, and by runs of
// rays where that is enough (packet/block_order.h), which is tried now and then.
//
// What frustums are no good for. A frustum that is too wide or meets too much, as those from a surface to a large light, costs
// more than it saves. Its rays go through the binary tree in groups, one ray in each SIMD lane (packet/ray_groups_simd.h), and
// at last singly, as rays do that make no packet. Blocks at intervals are trials: where most of the frustums of one were of no
// use, the blocks up to the next trial go in groups at once, and where the rays of a group were seldom in the same node,
// singly.
//
// Hits are those of single rays, bit for bit for the watertight test, whatever the options, but for those that core/hit.h
// excepts. With other tests there are no groups.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "libaccel/geometry/watertight.h"
#include "libaccel/packet/block_order.h"
#include "libaccel/packet/breadth_first.h"
#include "libaccel/packet/culling_simd.h"
#include "libaccel/packet/frustums_simd.h"
#include "libaccel/packet/localized_simd.h"
#include "libaccel/packet/packet_options.h"
#include "libaccel/packet/packet_set.h"
#include "libaccel/packet/ray_groups_simd.h"
#include "libaccel/packet/serial_primitives.h"

namespace accel {

// trace_singly(ray) is the hit of a single ray.
template <class Test, Query kQuery, class TraceSingly>
class PacketTracer {
 public:
  using Options = PacketOptions;
  using Answer = std::conditional_t<kQuery == Query::closest, Hit, std::uint8_t>;
  static constexpr bool kIsTuned = std::is_same_v<Test, Watertight>;
  static constexpr std::size_t kFewestRays = 8;

  // The view has octo nodes, unless the scene has but one leaf, and no path is longer than kBvh2StackSize.
  PacketTracer(const Bvh2View& view, const PacketOptions& options, TraceSingly trace_singly)
      : view_(view), options_(options), trace_singly_(trace_singly), order_(view.bounds, options.cell_fraction) {
    options_.max_size = std::clamp(options.max_size, 1u, kMaxPacketSize);
    options_.block_size = std::max(options.block_size, 1u);
    const Vec3 e = view.bounds.extent();
    widest_ = options.max_width * max_of(max_of(e.x, e.y), e.z);
  }

  // May throw std::bad_alloc.
  void trace(std::span<const Ray> rays, std::span<Answer> answers) {
    for (std::size_t first = 0; first < rays.size(); first += rays_.size()) {
      const bool is_trial = blocks_++ == next_trial_;
      const std::uint32_t most = is_trial ? std::min(options_.block_size, kTrialSize) : options_.block_size;
      const std::size_t n = std::min<std::size_t>(rays.size() - first, most);
      rays_ = rays.subspan(first, n), answers_ = answers.subspan(first, n);
      trace_block(is_trial);
    }
  }

 private:
  using Primitives = SerialPrimitives;
  static constexpr bool kHasGroups = kIsTuned;

  // How blocks begin; what is left goes the next way.
  enum class Way : std::uint8_t { frustums, groups, singly };

  static constexpr std::uint32_t kBlocksPerTrial = 8, kMostBlocksPerTrial = 64;
  static constexpr std::uint32_t kTrialSize = 8192;
  // A step of a group costs as much as some two steps of single rays, and more where all rays are sorted.
  static constexpr std::uint64_t kLeastRaysInStep = 2, kLeastSortedRaysInStep = 3;

  void trace_block(bool is_trial) {
    if (view_.octo_count == 0 || (way_ == Way::singly && !is_trial)) {
      for (std::size_t i = 0; i < rays_.size(); ++i) trace_singly(i);
      return;
    }
    std::fill(answers_.begin(), answers_.end(), Answer{});
    order_.begin(rays_);
    if (is_trial) {
      find_way();
    } else {
      order_.sort(run_);
      if (way_ == Way::frustums) trace_frustums();
      trace_groups();
    }
    for (const std::uint32_t id : order_.ids()) trace_singly(id);
  }

  void trace_singly(std::size_t id) { store_answer(trace_singly_(rays_[id]), answers_[id]); }

  // Traces a block in the way that the next ones take, too.
  void find_way() {
    const auto before = std::pair(way_, run_);
    if (const double as_they_come = width_by(0); width_by(run_ = 8) * kCostOfRuns > as_they_come) order_.sort(run_ = 0);
    if (!trace_by_packets(kLeastRaysInStep)) {
      order_.sort(run_ = 1);
      trace_by_packets(kLeastSortedRaysInStep);
    }
    trial_distance_ = std::pair(way_, run_) == before ? std::min(2 * trial_distance_, kMostBlocksPerTrial) : kBlocksPerTrial;
    next_trial_ += trial_distance_;
  }

  // Sorts by runs of so many rays (packet/block_order.h). Returns the width of frustums.
  double width_by(std::uint32_t run) {
    order_.sort(run);
    cut(std::min(options_.max_size, kComparedSize));
    make_frustums();
    return total_width();
  }

  // In the order that is, in whatever way is of use. Returns false if that is singly.
  bool trace_by_packets(std::uint64_t least_rays_in_step) {
    trace_frustums();
    way_ = 4 * order_.ids().size() > 3 * rays_.size() ? Way::groups : Way::frustums;
    const GroupWork work = trace_groups();
    if (way_ == Way::groups && work.rays <= least_rays_in_step * work.nodes) way_ = Way::singly;
    return way_ != Way::singly;
  }

  // Of all rays' frustums; those without one count as if they had the widest that is of use.
  double total_width() const {
    double sum = 0;
    std::size_t alone = rays_.size();
    for (std::size_t i = 0; i < packets_.count(); ++i) {
      sum += static_cast<double>(packets_.size_of(i)) * min_of(packets_.frustums()[i].width(), widest_);
      alone -= packets_.size_of(i);
    }
    return sum + static_cast<double>(alone) * widest_;
  }

  void cut(std::uint32_t size) {
    packets_.cut_by_face(order_.faces(), size, std::min(options_.min_size, size));
  }

  void make_frustums() {
    make_frustums_simd(packets_.batch(view_, rays_.data(), order_.ids().data()), order_.faces().data(), view_.bounds,
                       packets_.frustums().data());
  }

  // What is left in the order afterwards has no answer.
  void trace_frustums() {
    cut(options_.max_size);
    make_frustums();
    packets_.find_leaves(traversal_, view_, [this](std::size_t i) {
      // Nothing for frustums that are too wide to begin with.
      return packets_.frustums()[i].width() <= widest_ ? budget_for(options_.budget, packets_.size_of(i)) : 0u;
    });
    const LocalizedBatch batch = packets_.active(view_, rays_.data(), order_.ids().data());
    if constexpr (!std::is_same_v<Test, Watertight>)
      intersect_packets<Test, kQuery>(batch, answers_.data());
    else if constexpr (kQuery == Query::closest)
      intersect_watertight_simd(batch, answers_.data());
    else
      occlude_watertight_simd(batch, answers_.data());
    keep_what_is_left();
  }

  GroupWork trace_groups() {
    GroupWork work;
    if constexpr (kHasGroups) {
      if (order_.ids().empty()) return work;
      cut(options_.max_size);
      const LocalizedBatch batch = packets_.batch(view_, rays_.data(), order_.ids().data());
      if constexpr (kQuery == Query::closest)
        work = intersect_groups_simd(view_, batch, order_.faces().data(), answers_.data());
      else
        work = occlude_groups_simd(view_, batch, order_.faces().data(), answers_.data());
      keep_what_is_left();
    }
    return work;
  }

  void keep_what_is_left() {
    left_.clear();
    packets_.for_each_left([this](std::uint32_t first, std::uint32_t end) { left_.emplace_back(first, end); });
    order_.keep(left_);
  }

  Bvh2View view_;
  PacketOptions options_;
  TraceSingly trace_singly_;
  float widest_;  // of a frustum

  // How the next blocks are taken.
  Way way_ = Way::frustums;
  std::uint32_t run_ = 0;
  std::uint32_t blocks_ = 0;  // so far
  std::uint32_t next_trial_ = 0, trial_distance_ = kBlocksPerTrial;

  // Of the block.
  std::span<const Ray> rays_;
  std::span<Answer> answers_;
  BlockOrder order_;
  PacketSet<Primitives> packets_;
  BreadthFirst<Primitives, SimdCulling> traversal_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> left_;  // places in the order
};

}  // namespace accel
