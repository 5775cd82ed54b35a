// Traces batches of rays as packets: Garanzha and Loop 2010, "Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray
// Tracing" [GL10], section 3.
//
// Rays that follow each other make packets (packet/packet_ranges.h), packets frustums (packet/frustum.h), frustums go through
// an Octo-BVH together (packet/breadth_first.h), and rays are tested against the leaves that their frustum meets
// (packet/localized.h). The batch is taken in blocks, which bounds the memory and keeps it in the caches.
//
// Order. Within a block, rays of one face come one after the other. Where that makes narrower frustums, as for a picture's
// rows, blocks are sorted by hash values (packet/ray_hash.h) first, which is tried now and then: [GL10] sorts always. Rays
// whose frustum meets too much, and those that make no frustum, are traced one by one.
//
// Hits are those of single rays. In the registry the method is a traverser that is the stack version in all that concerns
// single rays: what counts their steps, models warps or streams, or runs on devices sees that one.
#pragma once

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <type_traits>
#include <vector>

#include "libaccel/geometry/watertight.h"
#include "libaccel/packet/breadth_first.h"
#include "libaccel/packet/culling_simd.h"
#include "libaccel/packet/frustums_simd.h"
#include "libaccel/packet/localized_simd.h"
#include "libaccel/packet/packet_ranges.h"
#include "libaccel/packet/ray_hash.h"
#include "libaccel/packet/serial_primitives.h"
#include "libaccel/trace/bvh2_stack.h"

namespace accel {

struct PacketOptions {
  std::uint32_t max_size = 256;      // rays a packet, 1 to kMaxPacketSize; [GL10] section 5.1
  std::uint32_t min_size = 8;        // smaller packets are traced ray by ray
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
      : view_(view), options_(options), trace_singly_(trace_singly) {
    options_.max_size = std::clamp(options.max_size, 1u, kMaxPacketSize);
    options_.block_size = std::max(options.block_size, 1u);
    hash_ = Hash::make(view.bounds, options.cell_fraction);
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
  using Hash = RayHash<std::uint64_t, kFineDirectionBits>;
  static constexpr std::uint32_t kFaces = kNoFace + 1;
  static constexpr std::uint32_t kBlocksPerTrial = 8;
  static constexpr double kWorthSorting = 0.6;  // of the width

  void trace_block() {
    std::fill(answers_.begin(), answers_.end(), Answer{});
    ids_.resize(rays_.size()), faces_.resize(rays_.size());
    std::iota(ids_.begin(), ids_.end(), 0u);
    if (view_.octo_count == 0) return trace_singly(0, ids_.size());
    find_faces();
    order_rays();
    gave_up_.resize(frustums_.size());
    const auto& leaves = traversal_.run(view_, frustums_.data(), frustums_.size(), budgets_.data(), gave_up_.data());
    intersect(leaves);
    trace_the_rest();
  }

  // The rays ids_[first] to ids_[end - 1].
  void trace_singly(std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) store_answer(trace_singly_(rays_[ids_[i]]), answers_[ids_[i]]);
  }

  void find_faces() {
    faces_by_ray_.resize(rays_.size());
    faces_count_.fill(0);
    for (std::size_t i = 0; i < rays_.size(); ++i)
      ++faces_count_[faces_by_ray_[i] = static_cast<std::uint8_t>(face_of(rays_[i]))];
  }

  // Keeps the order of ids_ among rays of one face.
  void sort_by_face() {
    std::array<std::uint32_t, kFaces> next = faces_count_;
    std::exclusive_scan(next.begin(), next.end(), next.begin(), 0u);
    unsorted_ = ids_;
    for (const std::uint32_t id : unsorted_) {
      const std::uint32_t at = next[faces_by_ray_[id]]++;
      ids_[at] = id, faces_[at] = faces_by_ray_[id];
    }
  }

  // Makes packets of the rays as they come or of sorted ones, whichever are narrower: both are tried now and then.
  void order_rays() {
    const bool tries = blocks_++ % kBlocksPerTrial == 0;
    double width_as_they_come = 0;
    if (tries || !sorts_) {
      sort_by_face();
      make_packets();
      width_as_they_come = total_width();
    }
    if (!tries && !sorts_) return;
    sort_by_hash();
    make_packets();
    if (!tries) return;
    sorts_ = total_width() < kWorthSorting * width_as_they_come;
    if (sorts_) return;
    std::iota(ids_.begin(), ids_.end(), 0u);
    sort_by_face();
    make_packets();
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

  void sort_by_hash() {
    Buffer<std::uint64_t> values(rays_.size());
    for (std::size_t i = 0; i < rays_.size(); ++i) values[i] = hash_(rays_[i]);
    std::iota(ids_.begin(), ids_.end(), 0u);
    Primitives::sort_pairs(values.data(), ids_.data(), values.size());
    sort_by_face();
  }

  void make_packets() {
    ranges_ = packet_ranges<Primitives>(faces_.data(), rays_.size(), options_.max_size);
    packets_.clear(), budgets_.clear();
    for (std::uint32_t p = 0; p < ranges_.count; ++p) {
      const std::uint32_t first = ranges_.base[p], size = ranges_.base[p + 1] - first;
      if (faces_[first] == kNoFace || size < options_.min_size) continue;
      packets_.push_back(p), budgets_.push_back(options_.budget * size);
    }
    frustums_.resize(packets_.size());
    make_frustums_simd(batch_of(packets_), faces_.data(), view_.bounds, frustums_.data());
    // Frustums that are too wide to begin with.
    for (std::size_t f = 0; f < frustums_.size(); ++f)
      if (!(frustums_[f].width() <= widest_)) budgets_[f] = 0;
  }

  LocalizedBatch batch_of(const std::vector<std::uint32_t>& packets) const {
    return {.nodes = view_.octo,
            .leaves = view_.leaves,
            .rays = rays_.data(),
            .ids = ids_.data(),
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

  // Rays without a frustum, and those whose frustum met too much.
  void trace_the_rest() {
    std::size_t next = 0;
    for (std::uint32_t p = 0; p < ranges_.count; ++p) {
      const bool has_frustum = next < packets_.size() && packets_[next] == p;
      if (!has_frustum || gave_up_[next] != 0) trace_singly(ranges_.base[p], ranges_.base[p + 1]);
      next += has_frustum ? 1 : 0;
    }
  }

  Bvh2View view_;
  PacketOptions options_;
  TraceSingly trace_singly_;
  Hash hash_;
  float widest_;              // of a frustum
  std::uint32_t blocks_ = 0;  // so far
  bool sorts_ = false;

  // Of the block.
  std::span<const Ray> rays_;
  std::span<Answer> answers_;
  std::vector<std::uint32_t> ids_, unsorted_;       // the order of rays
  std::vector<std::uint8_t> faces_, faces_by_ray_;  // faces_: in that order
  std::array<std::uint32_t, kFaces> faces_count_;   // rays of each face
  PacketRanges<Primitives> ranges_;
  std::vector<std::uint32_t> packets_, budgets_;  // of the frustums
  std::vector<Frustum> frustums_;
  std::vector<std::uint8_t> gave_up_;
  BreadthFirst<Primitives, SimdCulling> traversal_;
  std::vector<std::uint32_t> active_, firsts_;  // see LocalizedBatch
  std::vector<Frustum> active_frustums_;
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
