// Traces batches of rays through a Bvh8, or one of instances (structure/two_level_bvh8.h), in the way that is fastest for them:
// what people will use on a CPU.
//
// Rays that run nearly as the ones before, as those of a picture or to a light, go in packets (packet/bvh8_packets_simd.h), in
// the order of packet/block_order.h where that makes narrower frustums: tiles of a picture's rows, or runs of eight rays along
// a curve. All others, and those that make no packet, go by turns (trace/bvh8_simd.h). Rays that are alike need not
// share their way, as those to triangles smaller than the distance between them: now and then some packets' rays are traced in
// all ways, and the clock says which the others go in, and the next blocks. For any-hit queries these are three, since packets
// may begin at either end.
//
// Hits are those of single rays, bit for bit, whatever the options and the clock, but for those that core/hit.h excepts. In the
// registry the methods are traversers that are bvh8/ordered and bvh8-instances/ordered in all that concerns single rays: what
// counts their steps or models warps or streams sees these.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "libaccel/packet/block_order.h"
#include "libaccel/packet/bvh8_packets_simd.h"
#include "libaccel/packet/packet_options.h"
#include "libaccel/packet/packet_set.h"
#include "libaccel/packet/serial_primitives.h"
#include "libaccel/trace/bvh8_instances.h"
#include "libaccel/trace/bvh8_ordered.h"

namespace accel {

// Batches of fewer rays are not worth the preparation of packets.
inline constexpr std::size_t kFewestInPackets = 256;

// Whether most rays run nearly as the one before, in a sample of some dozens.
bool are_alike(std::span<const Ray> rays);

// How rays that are alike are traced until the next trial. All who trace parts of a batch share it; where two change it at a
// time, one change is lost, which costs a trial.
struct alignas(8) StreamPlan {  // as a word: clang calls a library for atomics of less alignment
  enum class Way : std::uint8_t { turns, packets, packets_from_far_end };
  static constexpr std::uint8_t kNotCompared = 255;
  Way way = Way::packets;
  std::uint8_t run = kNotCompared;  // rays that are sorted as one; 0: none are
  std::uint16_t trial_distance = 1;
  std::uint32_t blocks_to_trial = 0;
};
static_assert(std::atomic<StreamPlan>::is_always_lock_free);

// What rays go by turns with, by the kind of tree: one of triangles, or one of instances.
inline SimdFunctions<Bvh8View> functions_by_turns(const Bvh8View&) {
  return Bvh8Simd<Bvh8Node, PaddedSlabs, Watertight>::functions();
}
inline SimdFunctions<TwoLevelBvh8View> functions_by_turns(const TwoLevelBvh8View&) {
  return Bvh8InstancesSimd<Watertight>::functions();
}

// With the watertight test, by one thread. Answer is Hit, or std::uint8_t for any-hit queries.
template <class View, class Answer>
class Bvh8StreamTracer {
 public:
  Bvh8StreamTracer(const View& view, const PacketOptions& options, std::atomic<StreamPlan>& plan);

  // May throw std::bad_alloc.
  void trace(std::span<const Ray> rays, std::span<Answer> answers);

 private:
  static constexpr bool kIsAnyHit = std::is_same_v<Answer, std::uint8_t>;
  using Way = StreamPlan::Way;
  static constexpr std::size_t kWays = kIsAnyHit ? 3 : 2;

  void trace_alike(std::span<const Ray> rays, std::span<Answer> answers);
  // For packets whose frustums are narrower.
  std::uint8_t better_run(std::span<const Ray> rays);
  // Traces packets in some places of the block, one in each way, and plans the fastest.
  void try_ways(std::span<const Ray> rays, std::span<Answer> answers, StreamPlan& plan);
  // The first packet of a place.
  std::size_t first_of(std::size_t place) const;
  // The rays of the block's packets [first, end).
  void trace_packets(Way way, std::size_t first, std::size_t end, std::span<const Ray> rays, std::span<Answer> answers);
  void trace_by_turns(std::span<const Ray> rays, std::span<Answer> answers) const {
    functions_by_turns(view_).trace(view_, rays.data(), rays.size(), answers.data());
  }
  // By turns, rays at places of the order.
  void begin_gathering() { gathered_.clear(); }
  void gather(std::uint32_t first, std::uint32_t end) {
    for (std::uint32_t i = first; i < end; ++i) gathered_.push_back(order_.ids()[i]);
  }
  void trace_gathered(std::span<const Ray> rays, std::span<Answer> answers);
  // The block in runs of so many rays, cut into packets.
  void make_packets(std::uint32_t run, std::uint32_t size);
  // How wide the frustums of a block are in runs of so many rays, summed over rays.
  double width_in_runs(std::span<const Ray> rays, std::uint32_t run);

  View view_;
  PacketOptions options_;
  Aabb bounds_;
  std::atomic<StreamPlan>& plan_;

  // Of the block.
  BlockOrder order_;
  PacketSet<SerialPrimitives> packets_;
  std::vector<std::uint32_t> gathered_;
  std::vector<Ray> gathered_rays_;
  std::vector<Answer> gathered_answers_;
};

extern template class Bvh8StreamTracer<Bvh8View, Hit>;
extern template class Bvh8StreamTracer<Bvh8View, std::uint8_t>;
extern template class Bvh8StreamTracer<TwoLevelBvh8View, Hit>;
extern template class Bvh8StreamTracer<TwoLevelBvh8View, std::uint8_t>;

// Batches of the method: other tests than the watertight one have no packets. ByTurns are batches without packets.
template <class View, class Test, Query kQuery, class ByTurns, class TraceSingly>
class Bvh8StreamBatch {
 public:
  // One for all who trace parts of a batch.
  struct Options : PacketOptions {
    mutable std::atomic<StreamPlan> plan;
  };
  using Answer = std::conditional_t<kQuery == Query::closest, Hit, std::uint8_t>;
  static constexpr bool kIsTuned = ByTurns::kIsTuned;
  static constexpr std::size_t kFewestRays = 0;

  // Larger blocks make better packets; of rays that make none, small ones keep all threads busy to the end.
  static std::size_t rays_per_task(std::span<const Ray> rays, const Options& options) {
    return has_packets(rays) && are_alike(rays) ? options.block_size : typename ByTurns::Options{}.block_size;
  }

  Bvh8StreamBatch(const View& view, const Options& options, const TraceSingly& trace_singly)
      : view_(view), options_(options), trace_singly_(trace_singly) {}

  static void trace_one(const View& view, const Ray& ray, Answer& answer) requires(kIsTuned) {
    ByTurns::trace_one(view, ray, answer);
  }

  void trace(std::span<const Ray> rays, std::span<Answer> answers) const {
    if (has_packets(rays))
      Bvh8StreamTracer<View, Answer>(view_, options_, options_.plan).trace(rays, answers);
    else
      ByTurns(view_, {}, trace_singly_).trace(rays, answers);
  }

 private:
  static bool has_packets(std::span<const Ray> rays) {
    return std::is_same_v<Test, Watertight> && rays.size() >= kFewestInPackets;
  }

  const View& view_;
  const Options& options_;
  const TraceSingly& trace_singly_;
};

// Base: the traverser of single rays.
template <class Base, class Test, Query kQuery>
struct Bvh8StreamOf : Base {
  static constexpr const char* kName = "stream";
  static constexpr SkippedFeature kSkips{"steps of packets",
                                         "counters, profiles and single rays are those of the method 'ordered'"};

  template <class TraceSingly>
  using Batch = Bvh8StreamBatch<typename Base::View, Test, kQuery, typename Base::template Batch<TraceSingly>, TraceSingly>;
};

template <class Test, Query kQuery>
struct Bvh8Stream : Bvh8StreamOf<Bvh8Ordered<Test, kQuery>, Test, kQuery> {};
template <class Test, Query kQuery>
struct Bvh8InstancesStream : Bvh8StreamOf<Bvh8Instances<Test, kQuery>, Test, kQuery> {};

}  // namespace accel
