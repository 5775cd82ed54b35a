#include "libaccel/packet/warp_queue.h"

#include <gtest/gtest.h>

#include <deque>

#include "libaccel/core/counter_rng.h"
#include "libaccel/exec/simt_lanes.h"

namespace accel {
namespace {

// Against std::deque: lanes at random come and go, and the ring wraps many times.
TEST(WarpQueue, GivesWhatCameFirstToTheLowestLanes) {
  std::uint32_t memory[64];
  WarpQueue<std::uint32_t, 64> queue(memory);
  SimtLanes warp(0, 0);
  std::deque<std::uint32_t> expected;
  CounterRng rng(5, 0);
  std::uint32_t next = 0, most = 0;
  for (int turn = 0; turn < 2000; ++turn) {
    const LaneMask givers = static_cast<LaneMask>(rng.next_u64()) & static_cast<LaneMask>(rng.next_u64());
    if (expected.size() + warp.count(givers) <= 64) {
      queue.push(warp, givers, [&](int lane, auto&) { return 100 * (next + warp.rank(givers, lane)); });
      for (std::uint32_t i = 0; i < warp.count(givers); ++i) expected.push_back(100 * next++);
    }
    most = std::max(most, queue.size());
    const LaneMask takers = static_cast<LaneMask>(rng.next_u64()) & static_cast<LaneMask>(rng.next_u64());
    LaneMask served = 0;
    const LaneMask told = queue.take(warp, takers, [&](int lane, std::uint32_t entry, auto&) {
      served |= 1u << lane;
      ASSERT_EQ(entry, expected.front());
      expected.pop_front();
    });
    EXPECT_EQ(served, told);
    EXPECT_EQ(served & ~takers, 0u);
    EXPECT_TRUE(served == takers || expected.empty());
    EXPECT_EQ(queue.size(), expected.size());
  }
  EXPECT_GT(most, 56u);
  EXPECT_GT(next, 5000u);
}

TEST(WarpQueue, NobodyIsServedByAnEmptyOne) {
  std::uint32_t memory[32];
  WarpQueue<std::uint32_t, 32> queue(memory);
  SimtLanes warp(0, 0);
  EXPECT_EQ(queue.take(warp, kEveryLane, [](int, std::uint32_t, auto&) { FAIL(); }), 0u);
  queue.push(warp, 0, [](int, auto&) { return 0u; });
  EXPECT_EQ(queue.size(), 0u);
  EXPECT_EQ(warp.profile().queues.steps, 0u) << "nothing is issued for no lanes";
}

}  // namespace
}  // namespace accel
