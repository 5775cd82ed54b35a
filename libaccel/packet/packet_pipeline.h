// The pipeline of Garanzha and Loop 2010 [GL10], Fig. 1, to the letter: the whole batch goes through one stage after the other,
// and each stage tells its time.
//
//   hash -> compression, sort, decompression -> packet ranges -> frustums -> breadth-first traversal -> localized intersection
//
// It is what the paper's figures are measured with. For speed there is packet/packet_tracer.h, which takes blocks of rays
// that fit the caches through most of these stages, and sorts only where that pays.
//
// Hash values have 32 bits, as in [GL10]: 9 bits of the origin's cell for each axis and the face, so that packets do not mix
// faces. With kDirectionBits > 0, cells within the face count too, and the origin has that many bits less: rays from one cell
// to parts of a large light make packets of their own, as those of different strata do in [GL10], section 4.
//
// Hits are those of single rays (the watertight test), bit for bit. Rays without a face, packets smaller than min_size and
// frustums that meet more than their budget are traced by the caller's function; nothing is dropped.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "libaccel/packet/cpu_primitives.h"
#include "libaccel/packet/csd_sort.h"
#include "libaccel/packet/culling_simd.h"
#include "libaccel/packet/frustums_simd.h"
#include "libaccel/packet/localized_simd.h"
#include "libaccel/packet/packet_set.h"
#include "libaccel/packet/ray_hash.h"
#include "libaccel/packet/stage_clock.h"

namespace accel {

struct PipelineOptions {
  float cell_fraction = 0.004f;  // [GL10], section 5.1: UserCellFraction
  std::uint32_t max_size = 256;  // and MaxSize: rays a packet, 1 to kMaxPacketSize
  std::uint32_t min_size = 1;
  std::uint32_t budget = std::numeric_limits<std::uint32_t>::max();  // pairs of a frustum in the queue; [GL10] has no limit
};

// What the stages made of a batch.
struct PipelineCounts {
  std::size_t rays = 0;
  std::size_t chunks = 0;    // runs of equal hash values, as the rays came
  std::size_t frustums = 0;  // packets that have one
  std::size_t leaves = 0;    // that all frustums meet
  std::size_t warps = 0;     // of 32 rays, in the packets that meet anything; a warp has rays of one packet
  std::size_t warp_rays = 0;
  std::size_t alone = 0;  // rays that were traced one by one
};

// SimdCulling (packet/culling_simd.h), concurrently.
struct ParallelSimdCulling {
  template <class Primitives>
  static void cull(const OctoNode* nodes, const Frustum* frustums, const FrustumQueue<Primitives>& queue, std::uint8_t* masks) {
    for_chunks(0, queue.count, [&](std::size_t, std::size_t begin, std::size_t end) {
      cull_simd(nodes, frustums, queue.frustum.data() + begin, queue.place.data() + begin, end - begin, masks + begin);
    });
  }
};

// Runs on the threads of the calling thread's arena. All calls may throw std::bad_alloc.
template <Query kQuery, int kDirectionBits = 0>
class PacketPipeline {
 public:
  using Answer = std::conditional_t<kQuery == Query::closest, Hit, std::uint8_t>;

  // The view has octo nodes, unless the scene has but one leaf.
  PacketPipeline(const Bvh2View& view, const PipelineOptions& options)
      : view_(view), options_(options), hash_(Hash::make(view.bounds, options.cell_fraction)) {
    options_.max_size = std::clamp(options.max_size, 1u, kMaxPacketSize);
  }

  // answers[i] answers rays[i], fewer than 2^32; trace_singly(ray) is the hit of a single ray.
  template <class TraceSingly>
  void trace(std::span<const Ray> rays, std::span<Answer> answers, const TraceSingly& trace_singly) {
    rays_ = rays, times_ = {}, counts_ = {.rays = rays.size()};
    StageClock clock(times_);
    sort(clock);
    find_ranges();
    clock.lap(PacketStage::ranges);
    make_frustums();
    clock.lap(PacketStage::frustums);
    find_leaves();
    clock.lap(PacketStage::traversal);
    intersect(answers.data());
    clock.lap(PacketStage::localized);
    trace_the_rest(answers.data(), trace_singly);
    clock.lap(PacketStage::rest);
  }

  // Of the last batch; what they refer to is valid until the next one.
  const StageTimes& times() const { return times_; }
  const PipelineCounts& counts() const { return counts_; }
  const std::vector<Frustum>& frustums() const { return packets_.frustums(); }
  LocalizedBatch localized() const { return packets_.active(view_, rays_.data(), order_.ids.data()); }

 private:
  using Primitives = CpuPrimitives;
  using Hash = RayHash<std::uint32_t, kDirectionBits>;
  static constexpr std::uint32_t kNoKey = 0xffffffffu;  // of rays without a face; no hash value has its top bit
  static constexpr std::size_t kPacketsPerTask = 16;

  void sort(StageClock& clock) {
    const std::size_t n = rays_.size();
    std::uint32_t* const keys = with_room<Primitives, std::uint32_t>(keys_, n);
    std::uint8_t* const faces = with_room<Primitives, std::uint8_t>(faces_, n);
    for_chunks(0, n, [&](std::size_t, std::size_t begin, std::size_t end) {
      find_faces_simd(rays_.data() + begin, end - begin, faces + begin);
      for (std::size_t i = begin; i < end; ++i) keys[i] = faces[i] == kNoFace ? kNoKey : hash_(rays_[i]);
    });
    clock.lap(PacketStage::hash);
    order_ = csd_sort<Primitives>(std::as_const(keys), n, clock);
    counts_.chunks = order_.chunks;
  }

  void find_ranges() {
    const std::size_t n = rays_.size();
    const std::uint32_t *const keys = keys_.data(), *const ids = order_.ids.data();
    std::uint32_t* const sorted = with_room<Primitives, std::uint32_t>(sorted_, n);
    std::uint8_t* const faces = with_room<Primitives, std::uint8_t>(faces_, n);
    Primitives::for_each(n, [=](std::size_t i) {
      sorted[i] = keys[ids[i]];
      faces[i] = static_cast<std::uint8_t>(sorted[i] == kNoKey ? kNoFace : sorted[i] >> 2 * kDirectionBits & 7u);
    });
    // Without octo nodes no packet takes part.
    const std::uint32_t min_size = view_.octo_count > 0 ? options_.min_size : options_.max_size + 1;
    packets_.cut(std::as_const(sorted), faces, n, options_.max_size, min_size);
    counts_.frustums = packets_.count();
  }

  void make_frustums() {
    for_packets(packets_.batch(view_, rays_.data(), order_.ids.data()), [this](const LocalizedBatch& part, std::size_t begin) {
      make_frustums_simd(part, faces_.data(), view_.bounds, packets_.frustums().data() + begin);
    });
  }

  void find_leaves() {
    packets_.find_leaves(traversal_, view_, [this](std::size_t) { return options_.budget; });
    counts_.leaves = packets_.leaf_count();
  }

  // [GL10], section 3.4.
  void intersect(Answer* answers) {
    Primitives::for_each(rays_.size(), [=](std::size_t i) { answers[i] = Answer{}; });
    const LocalizedBatch batch = localized();
    for (std::size_t i = 0; i < batch.count; ++i) {
      const std::uint32_t size = batch.packets[batch.active[i] + 1] - batch.packets[batch.active[i]];
      counts_.warps += (size + 31) / 32, counts_.warp_rays += size;
    }
    for_packets(batch, [=](const LocalizedBatch& part, std::size_t) {
      if constexpr (kQuery == Query::closest)
        intersect_watertight_simd(part, answers);
      else
        occlude_watertight_simd(part, answers);
    });
  }

  // Rays without a frustum, and those whose frustum met too much.
  template <class TraceSingly>
  void trace_the_rest(Answer* answers, const TraceSingly& trace_singly) {
    rest_.clear();
    packets_.for_each_left([this](std::uint32_t first, std::uint32_t end) {
      rest_.insert(rest_.end(), order_.ids.begin() + first, order_.ids.begin() + end);
    });
    counts_.alone = rest_.size();
    Primitives::for_each(rest_.size(), [&](std::size_t i) { store_answer(trace_singly(rays_[rest_[i]]), answers[rest_[i]]); });
  }

  // body(part, begin) for parts of the batch, from packet `begin` on, concurrently.
  template <class Body>
  static void for_packets(const LocalizedBatch& batch, const Body& body) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, batch.count, kPacketsPerTask), [&](const auto& range) {
      LocalizedBatch part = batch;
      part.active += range.begin(), part.count = range.size();
      if (batch.frustums != nullptr) part.frustums += range.begin(), part.firsts += range.begin();
      body(part, range.begin());
    });
  }

  Bvh2View view_;
  PipelineOptions options_;
  Hash hash_;
  StageTimes times_;
  PipelineCounts counts_;

  // Of the batch. Arrays by ray, in the order of ids once that is known: sorted_ and faces_.
  std::span<const Ray> rays_;
  Buffer<std::uint32_t> keys_, sorted_;
  Buffer<std::uint8_t> faces_;
  CsdOrder<Primitives> order_;
  PacketSet<Primitives> packets_;
  BreadthFirst<Primitives, ParallelSimdCulling> traversal_;
  std::vector<std::uint32_t> rest_;  // rays
};

}  // namespace accel
