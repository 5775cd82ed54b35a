// Localized intersection by a warp whose lanes stay at work. Garanzha and Loop 2010 [GL10], section 3.4.
//
// In [GL10]'s kernel (Fig. 10; packet/localized_ray.h) a lane is a ray. It idles while other rays of its warp test the triangles
// of a leaf whose box it has missed, when an any-hit query has its answer, and where a packet has no ray for it. Here a lane
// takes whatever there is to test, of any ray in the warp's hand:
//
//   rays     as many as kRaysInHand, in memory that the warp shares; lanes fetch more, of whatever packet comes next, when there
//            is room for 32 (persistent threads, as in [GL10])
//   boxes    a queue of rays, each with the next leaf of its packet: 32 lanes take 32 of them, test the boxes, append those that
//            have leaves left again, and those that enter their leaf's box to
//   pairs    a queue of rays with a leaf. A lane that has none takes one, and tests one triangle of it at a time; this happens
//            whenever there are pairs for all lanes
//
// Rays that have their answer leave the queues without a test.
//
// Hits are those of single rays, since the nearest hit (the lowest prim_id among equals) does not depend on the order of tests.
// Boxes are tested with the hit of triangles tested so far, so a ray meets no fewer triangles than alone; the exception is that
// of exec/simt.h: a hit that rounding has moved out of its box may be found in more orders than one. Rays of a packet enter the
// queue of boxes together and come round together, at the next leaf: a step still reads few nodes and triangles. Whoever holds
// many rays tests few boxes too many, because the pairs of a ray have been tested when it comes round again.
//
// Bounds. A ray is in the queue of boxes once, so that has room for all in hand. Boxes are tested only while fewer than 32 pairs
// are ready, and each lane adds one at most: pairs never are more than 63.
//
// Memory: 72 bytes a ray in hand, and 512. Written against Lanes: packet/warp_queue.h.
#pragma once

#include <cstdint>

#include "libaccel/packet/localized_ray.h"
#include "libaccel/packet/warp_queue.h"

namespace accel {

// Steps of 32 are then seldom short of rays, and four warps have room in every device's shared memory.
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

// A ray in hand, by slot, with the next leaf to test, and with a triangle.
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
  std::uint32_t waiting[kRaysInHand];  // how many entries of queues, and lanes, have the ray
  std::uint32_t winners[kRaysInHand];  // which lane changes the ray's hit: of one step

  static constexpr std::uint32_t kPairs = 2 * kLanes;
  SlotAndPlace boxes[kRaysInHand];
  SlotAndQuad pairs[kPairs];
  std::uint32_t free[kRaysInHand];
};

template <class Test, Query kQuery, std::uint32_t kRaysInHand, class Lanes, class Answer>
class LocalizedWarp {
  static_assert(kRaysInHand >= kLanes);

 public:
  using Memory = LocalizedMemory<kRaysInHand>;

  // answers[i] will answer ray i of the tasks that the warp claims.
  ACCEL_HD LocalizedWarp(const LocalizedTasks& tasks, Answer* answers, Memory& memory, Lanes& warp)
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

  // The same, step by step: begin(), then step() until it returns false. A step tests boxes or triangles, where there are any.
  ACCEL_HD void begin() {
    for (std::uint32_t i = 0; i < kRaysInHand; i += kLanes)
      free_.push(warp_, kEveryLane, [&](int lane) { return i + static_cast<std::uint32_t>(lane); });
  }
  ACCEL_HD bool step() {
    fetch();
    const std::uint32_t ready = warp_.count(busy_) + pairs_.size();
    if (ready == 0 && boxes_.size() == 0) return false;
    if (ready >= kLanes || ready > boxes_.size())
      test_triangles();
    else
      test_boxes();
    return true;
  }

  std::uint32_t pairs() const { return pairs_.size(); }  // in the queue
  std::uint32_t boxes() const { return boxes_.size(); }

 private:
  template <class T>
  using PerLane = typename Lanes::template PerLane<T>;

  // Work of a lane in the queue of pairs, with what it has prepared for its ray.
  struct Pair {
    SlotAndQuad at;
    typename Test::RayData data;
  };

  ACCEL_HD void fetch() {
    while (has_tasks_ && free_.size() >= kLanes) {
      const ClaimedWork work = warp_.claim(kLanes, tasks_.count);
      const LaneMask lanes = warp_.where(kEveryLane, [&](int lane) { return static_cast<std::uint32_t>(lane) < work.count; });
      has_tasks_ = work.count == kLanes;
      PerLane<SlotAndPlace> rays;
      free_.take(warp_, lanes, [&](int lane, std::uint32_t slot) { rays[lane].slot = slot; });
      warp_.run(WarpStep::fetch, lanes, [&](int lane, auto& observer) {
        rays[lane].next = put(rays[lane].slot, work.first + static_cast<std::uint32_t>(lane), observer);
      });
      boxes_.push(warp_, lanes, [&](int lane) { return rays[lane]; });
    }
  }

  // Puts the ray of a task into a slot. Returns its first leaf.
  template <class Observer>
  ACCEL_HD std::uint32_t put(std::uint32_t slot, std::uint32_t number, Observer& observer) {
    const LocalizedTask task = tasks_.tasks[number];
    const Ray ray = tasks_.rays[task.ray];
    observer.load(accel::Memory::ray, tasks_.tasks + number, sizeof task);
    observer.load(accel::Memory::ray, tasks_.rays + task.ray, sizeof ray);
    observer.load(accel::Memory::node, tasks_.firsts + task.active, 2 * sizeof(std::uint32_t));
    memory_.rays[slot] = ray, memory_.ids[slot] = task.ray, memory_.ends[slot] = tasks_.firsts[task.active + 1];
    begin_hit(ray, memory_.hits[slot]);
    memory_.waiting[slot] = 1;
    return tasks_.firsts[task.active];
  }

  // An any-hit query that has its answer.
  ACCEL_HD bool is_answered(std::uint32_t slot) const { return kQuery == Query::any && memory_.hits[slot].valid(); }

  // Gives the lanes entries of rays that are not answered yet. Returns the lanes that have got one.
  template <class Queue, class Entries, class SlotOf>
  ACCEL_HD LaneMask take_unanswered(Queue& queue, LaneMask lanes, Entries& entries, const SlotOf& slot_of) {
    LaneMask served = 0;
    while (lanes != 0 && queue.size() > 0) {
      const LaneMask now = queue.take(warp_, lanes, [&](int lane, const auto& entry) { entries(lane) = entry; });
      const LaneMask answered = warp_.where(now, [&](int lane) { return is_answered(slot_of(lane)); });
      release(answered, slot_of);
      served |= now & ~answered, lanes = (lanes & ~now) | answered;
    }
    return served;
  }

  ACCEL_HD void test_boxes() {
    PerLane<SlotAndPlace> at;
    const auto slot_of = [&](int lane) { return at[lane].slot; };
    const auto entries = [&](int lane) -> SlotAndPlace& { return at[lane]; };
    const LaneMask lanes = take_unanswered(boxes_, kEveryLane, entries, slot_of);

    PerLane<std::uint32_t> quads;
    warp_.run(WarpStep::boxes, lanes, [&](int lane, auto& observer) {
      const Ray ray = memory_.rays[at[lane].slot];
      const auto box = ScalarBoxPairTest::prepare(ray, first_t(ray));
      quads[lane] =
          enter_leaf(tasks_.nodes, tasks_.places + at[lane].next++, box, memory_.hits[at[lane].slot].t, observer);
    });

    const LaneMask entered = warp_.where(lanes, [&](int lane) { return quads[lane] != kNoNode; });
    const LaneMask go_on = warp_.where(lanes, [&](int lane) { return at[lane].next < memory_.ends[at[lane].slot]; });
    pairs_.push(warp_, entered, [&](int lane) {
      ++memory_.waiting[slot_of(lane)];  // no other lane of this step has the ray
      return SlotAndQuad{slot_of(lane), quads[lane]};
    });
    boxes_.push(warp_, go_on, [&](int lane) { return at[lane]; });
    release(lanes & ~go_on, slot_of);
  }

  ACCEL_HD void test_triangles() {
    const auto slot_of = [&](int lane) { return pair_[lane].at.slot; };
    const auto entries = [&](int lane) -> SlotAndQuad& { return pair_[lane].at; };
    const LaneMask answered = warp_.where(busy_, [&](int lane) { return is_answered(slot_of(lane)); });
    release(answered, slot_of);
    busy_ &= ~answered;
    const LaneMask fresh = take_unanswered(pairs_, ~busy_, entries, slot_of);
    warp_.run(WarpStep::queues, fresh,
              [&](int lane, auto&) { pair_[lane].data = Test::prepare(memory_.rays[slot_of(lane)]); });
    busy_ |= fresh;

    PerLane<Hit> hits;
    PerLane<Phase> phases;
    PerLane<bool> is_nearer;
    warp_.run(WarpStep::triangles, busy_, [&](int lane, auto& observer) {
      const Ray ray = memory_.rays[slot_of(lane)];
      const Hit before = hits[lane] = memory_.hits[slot_of(lane)];
      phases[lane] = intersect_next<Test, kQuery>(tasks_.leaves, ray, pair_[lane].data, first_t(ray), pair_[lane].at.quad,
                                                  hits[lane], Phase::backtrack, observer);
      is_nearer[lane] = hits[lane].prim_id != before.prim_id;
    });
    accept(warp_.where(busy_, [&](int lane) { return is_nearer[lane]; }), hits);
    const LaneMask ended = warp_.where(busy_, [&](int lane) { return phases[lane] != Phase::intersect; });
    busy_ &= ~ended;
    release(ended, slot_of);
  }

  // Takes the candidates of the lanes: for each ray one after the other, as it has but one hit.
  ACCEL_HD void accept(LaneMask lanes, PerLane<Hit>& candidates) {
    while (lanes != 0) {
      const auto winner = [&](int lane) -> std::uint32_t& { return memory_.winners[pair_[lane].at.slot]; };
      warp_.run(WarpStep::queues, lanes,
                [&](int lane, auto&) { warp_.write_any(winner(lane), static_cast<std::uint32_t>(lane)); });
      const LaneMask now = warp_.where(lanes, [&](int lane) { return winner(lane) == static_cast<std::uint32_t>(lane); });
      warp_.run(WarpStep::queues, now, [&](int lane, auto&) {
        accept_hit(candidates[lane], candidates[lane].t, memory_.hits[pair_[lane].at.slot]);
      });
      lanes &= ~now;
    }
  }

  // The lanes leave their rays. Who is the last to leave a ray writes its answer and frees its slot.
  template <class SlotOf>
  ACCEL_HD void release(LaneMask lanes, const SlotOf& slot_of) {
    PerLane<bool> is_last;
    warp_.run(WarpStep::queues, lanes, [&](int lane, auto& observer) {
      is_last[lane] = warp_.add(memory_.waiting[slot_of(lane)], ~0u) == 1;
      if (is_last[lane]) answer(slot_of(lane), observer);
    });
    const LaneMask last = warp_.where(lanes, [&](int lane) { return is_last[lane]; });
    free_.push(warp_, last, slot_of);
  }

  template <class Observer>
  ACCEL_HD void answer(std::uint32_t slot, Observer& observer) {
    Hit hit = memory_.hits[slot];
    finish_hit(hit);
    Answer* const to = answers_ + memory_.ids[slot];
    store_answer(hit, *to);
    observer.store(accel::Memory::ray, to, sizeof *to);
  }

  const LocalizedTasks tasks_;
  Answer* answers_;
  Memory& memory_;
  Lanes& warp_;
  bool has_tasks_ = true;
  WarpQueue<SlotAndPlace, kRaysInHand> boxes_;
  WarpQueue<SlotAndQuad, Memory::kPairs> pairs_;
  WarpQueue<std::uint32_t, kRaysInHand> free_;
  LaneMask busy_ = 0;  // lanes that are in a leaf
  PerLane<Pair> pair_;
};

}  // namespace accel
