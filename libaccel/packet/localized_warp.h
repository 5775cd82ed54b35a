// Localized intersection by a warp whose lanes stay at work. Garanzha and Loop 2010 [GL10], section 3.4.
//
// In [GL10]'s kernel (Fig. 10; packet/localized_ray.h) a lane is a ray. It idles while other rays of its warp test the
// triangles of a leaf whose box it has missed, when an any-hit query has its answer, and where a packet has no ray for it. Here
// a lane takes whatever there is to test, of any ray in the warp's hand:
//
//   rays    as many as kRaysInHand, in memory that the warp shares. When half of it is free, lanes fetch more, of whatever
//           packets come next (persistent threads, as in [GL10])
//   boxes   a queue of rays, each with the next leaf of its packet. Lanes take one each, test the leaf's box, and put the ray
//           back if it has leaves left
//   pairs   a queue of rays with a leaf whose box they enter. A lane that has no pair takes one, and tests its triangles, one a
//           step; this happens whenever there are pairs for all lanes
//
// Rays that have their answer leave the queues without a test. They make few tests too many, because there are more rays in
// hand than lanes: the pairs of a ray have been tested, as a rule, when its turn comes again.
//
// Hits are those of single rays, since the nearest hit (the lowest prim_id among equals) does not depend on the order of tests.
// Boxes are tested with the hit of the triangles tested so far, so a ray meets no fewer triangles than alone. The exception is
// that of exec/simt.h: a hit that rounding has moved out of its box may be found in one order and not in another.
//
// Bounds. A ray is in the queue of boxes once: there is room for all in hand. Boxes are tested only while fewer than 32 pairs
// are ready, and each lane adds one at most: the queue of pairs never has more than 63.
//
// Costs. Rays that are fetched together go through the leaves of their packet together, but rays of several packets meet in a
// step, which reads more nodes and triangles than a warp of one packet: the more so, the fewer are fetched at a time. And
// queues take instructions, by count of PTX some 25 an operation, where a box has 70 (105 with what is prepared anew for each)
// and a triangle 95 to 310. By that estimate they spend what they save where any-hit rays meet many leaves, and cost half as
// many instructions again, or twice as many, where lanes were at work before. So devices use them on request only
// (DeviceTraceOptions::packet_queues), until one has told.
//
// Memory: 76 bytes a ray in hand, and 512. Written against Lanes: packet/warp_queue.h.
#pragma once

#include <cstdint>

#include "libaccel/packet/localized_ray.h"
#include "libaccel/packet/warp_queue.h"

namespace accel {

// Enough that a ray's turn comes after its pairs' as a rule; four warps have room in every device's shared memory.
inline constexpr std::uint32_t kLocalizedRaysInHand = 128;

// A ray by number, and its packet by its place among those that meet anything.
struct LocalizedTask {
  std::uint32_t ray, active;
};

// Rays of packets with the leaves that their frustums meet.
struct LocalizedTasks {
  const OctoNode* nodes = nullptr;
  const LeafQuad* leaves = nullptr;
  const Ray* rays = nullptr;
  const LocalizedTask* tasks = nullptr;
  const std::uint32_t* firsts = nullptr;  // active packet i has the places firsts[i] to firsts[i + 1] - 1
  const std::uint32_t* places = nullptr;  // of leaves: see FrustumQueue
  std::uint32_t count = 0;                // of tasks
};

// A ray in hand, by slot, with the place of its next leaf, and with a triangle of a leaf whose box it enters.
struct SlotAndPlace {
  std::uint32_t slot, next;
};
struct SlotAndQuad {
  std::uint32_t slot, quad;
};

template <std::uint32_t kRaysInHand>
struct LocalizedMemory {
  Ray rays[kRaysInHand];
  Hit hits[kRaysInHand];
  std::uint32_t ids[kRaysInHand];
  std::uint32_t ends[kRaysInHand];     // of the ray's leaves
  std::uint32_t entries[kRaysInHand];  // that the ray has in both queues and with lanes
  std::uint32_t winners[kRaysInHand];  // which lane changes the ray's hit: of one step

  static constexpr std::uint32_t kPairs = 2 * kLanes;
  SlotAndPlace boxes[kRaysInHand];
  SlotAndQuad pairs[kPairs];
  std::uint32_t free[kRaysInHand];
};

template <class Test, Query kQuery, std::uint32_t kRaysInHand, class Lanes, class Answer>
class LocalizedWarp {
  static_assert(kRaysInHand >= kLanes);
  static constexpr std::uint32_t kFetchedTogether = kRaysInHand / 2 < kLanes ? kLanes : kRaysInHand / 2;

 public:
  using SharedMemory = LocalizedMemory<kRaysInHand>;

  // answers[i] will answer ray i of the tasks that the warp claims.
  ACCEL_HD LocalizedWarp(const LocalizedTasks& tasks, Answer* answers, SharedMemory& memory, Lanes& warp)
      : tasks_(tasks),
        answers_(answers),
        memory_(memory),
        warp_(warp),
        boxes_(memory.boxes),
        pairs_(memory.pairs),
        free_(memory.free) {}

  ACCEL_HD void run() {
    begin();
    while (step()) {
    }
  }

  // The same, step by step: begin(), then step() until it returns false. A step tests boxes or triangles.
  ACCEL_HD void begin() {
    for (std::uint32_t i = 0; i < kRaysInHand; i += kLanes)
      free_.push(warp_, kEveryLane, [&](int lane, auto&) { return i + static_cast<std::uint32_t>(lane); });
  }
  ACCEL_HD bool step() {
    fetch();
    const std::uint32_t pairs = warp_.count(busy_) + pairs_.size();
    if (pairs == 0 && boxes_.size() == 0) return false;
    if (pairs >= kLanes || pairs > boxes_.size())
      test_triangles();
    else
      test_boxes();
    return true;
  }

  // In queues.
  std::uint32_t waiting_boxes() const { return boxes_.size(); }
  std::uint32_t waiting_pairs() const { return pairs_.size(); }

 private:
  template <class T>
  using PerLane = typename Lanes::template PerLane<T>;

  ACCEL_HD void fetch() {
    if (free_.size() < kFetchedTogether) return;
    while (has_tasks_ && free_.size() >= kLanes) {
      const ClaimedWork work = warp_.claim(kLanes, tasks_.count);
      has_tasks_ = work.count == kLanes;
      const LaneMask lanes = warp_.where(kEveryLane, [&](int lane) { return static_cast<std::uint32_t>(lane) < work.count; });
      PerLane<SlotAndPlace> rays;
      free_.take(warp_, lanes, [&](int lane, std::uint32_t slot, auto&) { rays[lane].slot = slot; });
      warp_.run(WarpStep::fetch, lanes, [&](int lane, auto& observer) {
        rays[lane].next = put(rays[lane].slot, work.first + static_cast<std::uint32_t>(lane), observer);
      });
      boxes_.push(warp_, lanes, [&](int lane, auto&) { return rays[lane]; });
    }
  }

  // Puts the ray of a task into a slot. Returns its first leaf.
  template <class Observer>
  ACCEL_HD std::uint32_t put(std::uint32_t slot, std::uint32_t number, Observer& observer) {
    const LocalizedTask task = tasks_.tasks[number];
    const Ray ray = tasks_.rays[task.ray];
    observer.load(Memory::ray, tasks_.tasks + number, sizeof task);
    observer.load(Memory::ray, tasks_.rays + task.ray, sizeof ray);
    observer.load(Memory::node, tasks_.firsts + task.active, 2 * sizeof(std::uint32_t));
    memory_.rays[slot] = ray, memory_.ids[slot] = task.ray, memory_.ends[slot] = tasks_.firsts[task.active + 1];
    memory_.entries[slot] = 1;
    begin_hit(ray, memory_.hits[slot]);
    return tasks_.firsts[task.active];
  }

  // Each lane tests the box of a ray's next leaf.
  ACCEL_HD void test_boxes() {
    PerLane<SlotAndPlace> at;
    PerLane<ScalarBoxPairTest> boxes;
    const LaneMask lanes = take_unanswered(
        boxes_, kEveryLane, at, [&](int lane, const Ray& ray) { boxes[lane] = ScalarBoxPairTest::prepare(ray, first_t(ray)); });
    PerLane<std::uint32_t> quads;
    PerLane<bool> is_last;
    warp_.run(WarpStep::boxes, lanes, [&](int lane, auto& observer) {
      const std::uint32_t slot = at[lane].slot;
      quads[lane] = enter_leaf(tasks_.nodes, tasks_.places + at[lane].next++, boxes[lane], memory_.hits[slot].t, observer);
      // No other lane of this step has the ray.
      memory_.entries[slot] += (goes_on(at[lane]) ? 1u : 0u) + (quads[lane] != kNoNode ? 1u : 0u) - 1u;
      is_last[lane] = memory_.entries[slot] == 0;
    });
    const LaneMask entered = warp_.where(lanes, [&](int lane) { return quads[lane] != kNoNode; });
    const LaneMask go_on = warp_.where(lanes, [&](int lane) { return goes_on(at[lane]); });
    pairs_.push(warp_, entered, [&](int lane, auto&) { return SlotAndQuad{at[lane].slot, quads[lane]}; });
    boxes_.push(warp_, go_on, [&](int lane, auto&) { return at[lane]; });
    answer(warp_.where(lanes, [&](int lane) { return is_last[lane]; }), at);
  }
  ACCEL_HD bool goes_on(const SlotAndPlace& at) const { return at.next < memory_.ends[at.slot]; }

  // Each lane tests a triangle of its pair.
  ACCEL_HD void test_triangles() {
    drop_answered(busy_, pair_);
    busy_ |= take_unanswered(pairs_, ~busy_, pair_, [&](int lane, const Ray& ray) { data_[lane] = Test::prepare(ray); });
    PerLane<Hit> hits;
    PerLane<bool> is_nearer, has_ended, is_last;
    warp_.run(WarpStep::triangles, busy_, [&](int lane, auto& observer) {
      const std::uint32_t slot = pair_[lane].slot;
      const Ray ray = memory_.rays[slot];
      const Hit before = hits[lane] = memory_.hits[slot];
      const Phase phase = intersect_next<Test, kQuery>(tasks_.leaves, ray, data_[lane], first_t(ray), pair_[lane].quad,
                                                       hits[lane], Phase::backtrack, observer);
      is_nearer[lane] = hits[lane].prim_id != before.prim_id;
      has_ended[lane] = phase != Phase::intersect;
      is_last[lane] = has_ended[lane] && leave(slot);
    });
    accept(warp_.where(busy_, [&](int lane) { return is_nearer[lane]; }), hits);
    answer(warp_.where(busy_, [&](int lane) { return is_last[lane]; }), pair_);
    busy_ &= ~warp_.where(busy_, [&](int lane) { return has_ended[lane]; });
  }

  // Takes the candidates of the lanes: for each ray one after the other, as it has but one hit.
  ACCEL_HD void accept(LaneMask lanes, PerLane<Hit>& candidates) {
    const auto winner = [&](int lane) -> std::uint32_t& { return memory_.winners[pair_[lane].slot]; };
    while (lanes != 0) {
      warp_.run(WarpStep::queues, lanes,
                [&](int lane, auto&) { warp_.write_any(winner(lane), static_cast<std::uint32_t>(lane)); });
      const LaneMask now = warp_.where(lanes, [&](int lane) { return winner(lane) == static_cast<std::uint32_t>(lane); });
      warp_.run(WarpStep::queues, now,
                [&](int lane, auto&) { accept_hit(candidates[lane], candidates[lane].t, memory_.hits[pair_[lane].slot]); });
      lanes &= ~now;
    }
  }

  // Gives the lanes entries of a queue, as long as there are any, of rays that are not answered yet, and prepares for their
  // rays. Returns the lanes that have got one.
  template <class Queue, class Entries, class Prepare>
  ACCEL_HD LaneMask take_unanswered(Queue& queue, LaneMask lanes, Entries& entries, const Prepare& prepare) {
    LaneMask served = 0;
    while (lanes != served && queue.size() > 0) {
      LaneMask now = queue.take(warp_, lanes & ~served, [&](int lane, const auto& entry, auto&) {
        entries[lane] = entry;
        prepare(lane, memory_.rays[entry.slot]);
      });
      drop_answered(now, entries);
      served |= now;
    }
    return served;
  }

  // Takes the lanes from the set whose any-hit queries have their answer.
  template <class Entries>
  ACCEL_HD void drop_answered(LaneMask& lanes, Entries& entries) {
    if constexpr (kQuery == Query::any) {
      const LaneMask answered = warp_.where(lanes, [&](int lane) { return memory_.hits[entries[lane].slot].valid(); });
      PerLane<bool> is_last;
      warp_.run(WarpStep::queues, answered, [&](int lane, auto&) { is_last[lane] = leave(entries[lane].slot); });
      answer(warp_.where(answered, [&](int lane) { return is_last[lane]; }), entries);
      lanes &= ~answered;
    }
  }

  // Whether this was the last entry of the ray.
  ACCEL_HD bool leave(std::uint32_t slot) { return warp_.add(memory_.entries[slot], ~0u) == 1; }

  // Writes the answers of rays that have no entry left, and frees their slots.
  template <class Entries>
  ACCEL_HD void answer(LaneMask lanes, Entries& entries) {
    free_.push(warp_, lanes, [&](int lane, auto& observer) {
      const std::uint32_t slot = entries[lane].slot;
      Hit hit = memory_.hits[slot];
      finish_hit(hit);
      Answer* const to = answers_ + memory_.ids[slot];
      store_answer(hit, *to);
      observer.store(Memory::ray, to, sizeof *to);
      return slot;
    });
  }

  const LocalizedTasks tasks_;
  Answer* answers_;
  SharedMemory& memory_;
  Lanes& warp_;
  bool has_tasks_ = true;
  WarpQueue<SlotAndPlace, kRaysInHand> boxes_;
  WarpQueue<SlotAndQuad, SharedMemory::kPairs> pairs_;
  WarpQueue<std::uint32_t, kRaysInHand> free_;

  LaneMask busy_ = 0;  // lanes that have a pair
  PerLane<SlotAndQuad> pair_;
  PerLane<typename Test::RayData> data_;
};

}  // namespace accel
