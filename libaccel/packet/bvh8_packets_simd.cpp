#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/packet/bvh8_packets_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>
#include <memory>

#include "libaccel/packet/bvh8_packets_simd.h"
#include "libaccel/packet/instance_packets_simd-inl.h"
#include "libaccel/packet/packet_flight_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// Packets on their way at a time: while memory answers one, others go on. Few, for each has some 20 KB of rays. Of any-hit
// queries one, since the next one begins with the leaf that has stopped it.
template <Query kQuery>
constexpr std::uint32_t kPacketsInTurn = kQuery == Query::closest ? 4 : 1;

// The packets of a batch, by turns.
template <Query kQuery, class View, class Answer>
class Flights {
 public:
  HWY_INLINE Flights(const View& view, const LocalizedBatch& batch, const std::uint8_t* faces, bool from_far_end,
                     Answer* answers)
      : view_(view),
        batch_(batch),
        faces_(faces),
        bounds_(bounds_of_children(view.nodes[view.root])),
        from_far_end_(from_far_end),
        answers_(answers) {}

  HWY_INLINE void trace() {
    constexpr std::uint32_t kMost = kPacketsInTurn<kQuery>;
    const auto most = static_cast<std::uint32_t>(std::min<std::size_t>(kMost, batch_.count));
    const auto flights = std::make_unique_for_overwrite<Flight[]>(most);  // too large for some stacks
    std::uint32_t count = 0;
    while (count < most && begin(flights[count])) ++count;
    Flight* in_turn[kMost];
    for (std::uint32_t i = 0; i < count; ++i) in_turn[i] = &flights[i];
    while (count > 0)
      for (std::uint32_t i = 0; i < count;) {
        Flight& f = *in_turn[i];
        if (HWY_LIKELY(go_on(view_, f, *leaves_))) {
          ++i;
        } else {
          store_answers(f.packet, answers_);
          if (!begin(f)) in_turn[i] = in_turn[--count];
        }
      }
  }

 private:
  // The batch's next packet that the occluder does not stop as a whole. Returns false if there is none.
  HWY_INLINE bool begin(Flight& f) {
    for (;;) {
      if (next_ == batch_.count) return false;
      const std::uint8_t face = load_next(f.packet);
      f.answered = kQuery == Query::any ? leaves_->ask_occluder(view_, f.packet) : 0;
      if (f.answered < f.packet.size) {
        HWY_NAMESPACE::begin(f, view_.root, face, bounds_, from_far_end_);
        return true;
      }
      store_answers(f.packet, answers_);
    }
  }

  // The next packet, or part of a packet of more than kMostGroups. Returns its face.
  HWY_INLINE std::uint8_t load_next(Packet& p) {
    const std::uint32_t packet = batch_.active[next_], first = batch_.packets[packet] + taken_;
    const std::uint32_t left = batch_.packets[packet + 1] - first,
                        size = std::min({left, kMostGroups * width(), kMaxPacketSize});
    taken_ = size < left ? taken_ + size : 0, next_ += size < left ? 0 : 1;
    load_rays(batch_.rays, batch_.ids + first, size, faces_[first] >> 1, p);
    if constexpr (kQuery == Query::any) p.reach = reach_of(p, bounds_);
    return faces_[first];
  }

  const View& view_;
  const LocalizedBatch& batch_;
  const std::uint8_t* faces_;
  Aabb bounds_;
  bool from_far_end_;
  Answer* answers_;
  std::size_t next_ = 0;     // of the batch's active packets
  std::uint32_t taken_ = 0;  // of its rays
  std::unique_ptr<Leaves<kQuery, View>> leaves_ =
      std::make_unique_for_overwrite<Leaves<kQuery, View>>();  // too large for some stacks
};

template <Query kQuery, class View, class Answer>
HWY_INLINE void trace_packets(const View& view, const LocalizedBatch& batch, const std::uint8_t* faces, bool from_far_end,
                              Answer* answers) {
  Flights<kQuery, View, Answer>(view, batch, faces, from_far_end, answers).trace();
}

void intersect(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits) {
  trace_packets<Query::closest>(view, batch, faces, false, hits);
}
void intersect_instances(const TwoLevelBvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits) {
  trace_packets<Query::closest>(view, batch, faces, false, hits);
}
void occlude(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, bool from_far_end,
             std::uint8_t* occluded) {
  trace_packets<Query::any>(view, batch, faces, from_far_end, occluded);
}
void occlude_by_instances(const TwoLevelBvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces,
                          bool from_far_end, std::uint8_t* occluded) {
  trace_packets<Query::any>(view, batch, faces, from_far_end, occluded);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(intersect);
HWY_EXPORT(intersect_instances);
HWY_EXPORT(occlude);
HWY_EXPORT(occlude_by_instances);

void trace_bvh8_packets_simd(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits) {
  HWY_DYNAMIC_DISPATCH(intersect)(view, batch, faces, hits);
}
void trace_bvh8_packets_simd(const TwoLevelBvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits) {
  HWY_DYNAMIC_DISPATCH(intersect_instances)(view, batch, faces, hits);
}
void trace_bvh8_packets_simd(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces,
                             std::uint8_t* occluded, bool from_far_end) {
  HWY_DYNAMIC_DISPATCH(occlude)(view, batch, faces, from_far_end, occluded);
}
void trace_bvh8_packets_simd(const TwoLevelBvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces,
                             std::uint8_t* occluded, bool from_far_end) {
  HWY_DYNAMIC_DISPATCH(occlude_by_instances)(view, batch, faces, from_far_end, occluded);
}
}  // namespace accel
#endif
