// Traces batches of rays as packets: Garanzha and Loop 2010, "Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray
// Tracing" [GL10], section 3.
//
// Rays that follow each other make packets (packet/packet_ranges.h), packets frustums (packet/frustum.h), frustums go through
// an Octo-BVH together (packet/breadth_first.h), and rays are tested against the leaves that their frustum meets
// (packet/localized.h). The batch is taken in blocks, which bounds the memory and keeps it in the caches.
//
// Order. [GL10] sorts all rays. Here that is done where it makes narrower frustums, as for a picture's rows, and by runs of
// rays where that is enough (packet/block_order.h), which is tried now and then.
//
// What packets are no good for. Rays whose frustum is too wide or meets too much are cut into packets of a quarter of the size,
// and at last traced singly, like rays that make no frustum. Where the packets of a block were mostly of no use, the next
// blocks are traced singly until the next trial.
//
// Hits are those of single rays. In the registry the method is a traverser that is the stack version in all that concerns
// single rays: what counts their steps or models warps or streams sees that one. Devices run packet/packet_batch.h.
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
#include "libaccel/packet/packet_ranges.h"
#include "libaccel/packet/serial_primitives.h"
#include "libaccel/trace/bvh2_stack.h"

namespace accel {

struct PacketOptions {
  std::uint32_t max_size = 256;      // rays a packet, 1 to kMaxPacketSize; [GL10] section 5.1
  std::uint32_t min_size = 8;        // smaller packets are traced ray by ray
  std::uint32_t min_split = 16;      // packets are not cut into smaller ones
  std::uint32_t block_size = 32768;  // rays
  float cell_fraction = 0.004f;      // of the hash; [GL10] section 5.1
  float max_width = 0.25f;           // of a frustum, as a share of the scene's longest side
  std::uint32_t budget = 2;          // pairs in the queue per ray of a frustum
};

// trace_singly(ray) is the hit of a single ray.
template <class Test, Query kQuery, class TraceSingly>
class PacketTracer {
 public:
  using Options = PacketOptions;
  using Answer = std::conditional_t<kQuery == Query::closest, Hit, std::uint8_t>;

  // The view has octo nodes, unless the scene has but one leaf.
  PacketTracer(const Bvh2View& view, const PacketOptions& options, TraceSingly trace_singly)
      : view_(view), options_(options), trace_singly_(trace_singly), order_(view.bounds, options.cell_fraction) {
    options_.max_size = std::clamp(options.max_size, 1u, kMaxPacketSize);
    options_.block_size = std::max(options.block_size, 1u);
    const Vec3 e = view.bounds.extent();
    widest_ = options.max_width * max_of(max_of(e.x, e.y), e.z);
  }

  // May throw std::bad_alloc.
  void trace(std::span<const Ray> rays, std::span<Answer> answers) {
    for (std::size_t first = 0; first < rays.size(); first += options_.block_size) {
      const std::size_t n = std::min<std::size_t>(rays.size() - first, options_.block_size);
      rays_ = rays.subspan(first, n), answers_ = answers.subspan(first, n);
      trace_block();
    }
  }

 private:
  using Primitives = SerialPrimitives;

  // What BlockOrder sorts by, and a factor on the widths of frustums for what that costs.
  struct Order {
    std::uint32_t run;
    double cost;
  };
  static constexpr std::array<Order, 3> kOrders = {{{0, 1}, {8, 1.1}, {1, 1.7}}};
  static constexpr std::uint32_t kBlocksPerTrial = 8, kMostBlocksPerTrial = 64;
  static constexpr std::uint32_t kSplit = 4;

  void trace_block() {
    const bool is_trial = blocks_++ == next_trial_;
    if (view_.octo_count == 0 || (is_scattered_ && !is_trial)) {
      for (std::size_t i = 0; i < rays_.size(); ++i) trace_singly(i);
      return;
    }
    std::fill(answers_.begin(), answers_.end(), Answer{});
    order_.begin(rays_);
    if (is_trial)
      try_orders();
    else
      sort_and_cut(run_);
    trace_packets();
    if (is_trial) is_scattered_ = 4 * order_.ids().size() > 3 * rays_.size();
    for (const std::uint32_t id : order_.ids()) trace_singly(id);
  }

  void trace_singly(std::size_t id) { store_answer(trace_singly_(rays_[id]), answers_[id]); }

  // What is left in the order afterwards has no answer.
  void trace_packets() {
    for (std::uint32_t size = options_.max_size;;) {
      const std::size_t before = order_.ids().size();
      gave_up_.resize(frustums_.size());
      intersect(traversal_.run(view_, frustums_.data(), frustums_.size(), budgets_.data(), gave_up_.data()));
      keep_unanswered();
      size /= kSplit;
      if (order_.ids().empty() || 2 * order_.ids().size() > before || size < options_.min_split) return;
      cut(size);
    }
  }

  // Sorts the block in the way that makes the narrowest frustums, and remembers it.
  void try_orders() {
    const std::uint32_t before = run_;
    double least = std::numeric_limits<double>::infinity();
    for (const Order& order : kOrders) {
      sort_and_cut(order.run);
      const double cost = total_width() * order.cost;
      if (cost < least) least = cost, run_ = order.run;
    }
    if (run_ != kOrders.back().run) sort_and_cut(run_);
    trial_distance_ = run_ == before ? std::min(2 * trial_distance_, kMostBlocksPerTrial) : kBlocksPerTrial;
    next_trial_ += trial_distance_;
  }

  // Of all rays' frustums; those without one count as if they had the widest that is of use.
  double total_width() const {
    double sum = 0;
    std::size_t alone = rays_.size();
    for (std::size_t f = 0; f < frustums_.size(); ++f) {
      const std::uint32_t size = ranges_.base[packets_[f] + 1] - ranges_.base[packets_[f]];
      sum += static_cast<double>(size) * min_of(frustums_[f].width(), widest_);
      alone -= size;
    }
    return sum + static_cast<double>(alone) * widest_;
  }

  void sort_and_cut(std::uint32_t run) {
    order_.sort(run);
    cut(options_.max_size);
  }

  // Cuts what is in the order into packets, and makes their frustums.
  void cut(std::uint32_t max_size) {
    const std::uint8_t* const faces = order_.faces().data();
    ranges_ = packet_ranges<Primitives>(faces, order_.faces().size(), max_size);
    packets_.clear(), budgets_.clear();
    for (std::uint32_t p = 0; p < ranges_.count; ++p) {
      const std::uint32_t first = ranges_.base[p], size = ranges_.base[p + 1] - first;
      if (faces[first] == kNoFace || size < options_.min_size) continue;
      packets_.push_back(p), budgets_.push_back(options_.budget * size);
    }
    frustums_.resize(packets_.size());
    make_frustums_simd(batch_of(packets_), faces, view_.bounds, frustums_.data());
    // Frustums that are too wide to begin with.
    for (std::size_t f = 0; f < frustums_.size(); ++f)
      if (!(frustums_[f].width() <= widest_)) budgets_[f] = 0;
  }

  LocalizedBatch batch_of(const std::vector<std::uint32_t>& packets) const {
    return {.nodes = view_.octo,
            .leaves = view_.leaves,
            .rays = rays_.data(),
            .ids = order_.ids().data(),
            .packets = ranges_.base.data(),
            .active = packets.data(),
            .count = packets.size()};
  }

  // The packets whose frustums meet anything, with the leaves that they meet: [GL10], end of section 3.3.
  void intersect(const FrustumQueue<Primitives>& leaves) {
    const auto active = detail::compress<Primitives>(leaves.frustum.data(), leaves.count);
    active_.clear(), firsts_.clear(), active_frustums_.clear();
    for (std::size_t i = 0; i < active.count; ++i) {
      active_.push_back(packets_[active.hash[i]]), active_frustums_.push_back(frustums_[active.hash[i]]);
      firsts_.push_back(active.base[i]);
    }
    firsts_.push_back(static_cast<std::uint32_t>(leaves.count));
    LocalizedBatch batch = batch_of(active_);
    batch.frustums = active_frustums_.data(), batch.firsts = firsts_.data(), batch.places = leaves.place.data();
    if constexpr (!std::is_same_v<Test, Watertight>)
      intersect_packets<Test, kQuery>(batch, answers_.data());
    else if constexpr (kQuery == Query::closest)
      intersect_watertight_simd(batch, answers_.data());
    else
      occlude_watertight_simd(batch, answers_.data());
  }

  // Keeps rays without a frustum, and those whose frustum met too much.
  void keep_unanswered() {
    unanswered_.clear();
    std::size_t next = 0;
    for (std::uint32_t p = 0; p < ranges_.count; ++p) {
      const bool has_frustum = next < packets_.size() && packets_[next] == p;
      if (!has_frustum || gave_up_[next] != 0) unanswered_.emplace_back(ranges_.base[p], ranges_.base[p + 1]);
      next += has_frustum ? 1 : 0;
    }
    order_.keep(unanswered_);
  }

  Bvh2View view_;
  PacketOptions options_;
  TraceSingly trace_singly_;
  float widest_;  // of a frustum

  // How the next blocks are taken.
  std::uint32_t run_ = 0;
  bool is_scattered_ = false;
  std::uint32_t blocks_ = 0;  // so far
  std::uint32_t next_trial_ = 0, trial_distance_ = kBlocksPerTrial;

  // Of the block.
  std::span<const Ray> rays_;
  std::span<Answer> answers_;
  BlockOrder order_;
  PacketRanges<Primitives> ranges_;
  std::vector<std::uint32_t> packets_, budgets_;  // of the frustums
  std::vector<Frustum> frustums_;
  std::vector<std::uint8_t> gave_up_;
  BreadthFirst<Primitives, SimdCulling> traversal_;
  std::vector<std::uint32_t> active_, firsts_;  // see LocalizedBatch
  std::vector<Frustum> active_frustums_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> unanswered_;  // places in the order
};

// The method. Executors on CPUs trace batches by PacketTracer, see exec/cpu.h.
template <class Test, Query kQuery>
struct Bvh2BreadthFirst : Bvh2Stack<Test, kQuery> {
  static constexpr const char* kName = "breadth-first";
  static constexpr Bvh2Extras kNeeds = Bvh2Extras::octo;
  static constexpr SkippedFeature kSkips{"steps of packets",
                                         "counters, profiles and single rays are those of the stack version"};

  template <class TraceSingly>
  using Batch = PacketTracer<Test, kQuery, TraceSingly>;
};

}  // namespace accel
