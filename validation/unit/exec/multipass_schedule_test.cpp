#include "libaccel/exec/multipass_schedule.h"

#include <gtest/gtest.h>

#include <vector>

#include "libaccel/core/counter_rng.h"
#include "validation/unit/exec/multipass_rules.h"

namespace accel {
namespace {

using Kernel = MultipassKernel;

MultipassCounts counts(std::uint32_t down, std::uint32_t leaf, std::uint32_t intersect, std::uint32_t continues,
                       std::uint32_t up) {
  MultipassCounts waiting;
  waiting[Kernel::down] = down, waiting[Kernel::leaf] = leaf, waiting[Kernel::intersect] = intersect;
  waiting[Kernel::continue_search] = continues, waiting[Kernel::up] = up;
  return waiting;
}

TEST(MultipassSchedule, DelanyLeavesWhenMoreThanTwiceAsManyWaitForTheNext) {
  const auto choose = [](Kernel current, const MultipassCounts& waiting) {
    return choose_kernel(MultipassRule::delany, current, waiting);
  };
  EXPECT_EQ(choose(Kernel::down, counts(100, 200, 0, 0, 0)), Kernel::down);
  EXPECT_EQ(choose(Kernel::down, counts(100, 201, 0, 0, 0)), Kernel::leaf);
  EXPECT_EQ(choose(Kernel::down, counts(100, 0, 201, 0, 0)), Kernel::intersect) << "nobody waits for leaf";
  EXPECT_EQ(choose(Kernel::down, counts(100, 1, 900, 0, 0)), Kernel::down) << "leaf is next, and has one ray";
  EXPECT_EQ(choose(Kernel::up, counts(21, 0, 50, 0, 10)), Kernel::down) << "the flow is a cycle";
  EXPECT_EQ(choose(Kernel::intersect, counts(0, 0, 7, 0, 0)), Kernel::intersect);
  EXPECT_EQ(choose(Kernel::continue_search, counts(5, 0, 9, 0, 0)), Kernel::down) << "kd-restart has no up";
}

TEST(MultipassSchedule, DelanyDoesNotOverflow) {
  constexpr std::uint32_t kHalf = 1u << 31;
  EXPECT_EQ(choose_kernel(MultipassRule::delany, Kernel::down, counts(kHalf, kHalf, 0, 0, 0)), Kernel::down);
}

TEST(MultipassSchedule, LargestFirstTakesTheMajority) {
  const auto choose = [](const MultipassCounts& waiting) {
    return choose_kernel(MultipassRule::largest_first, Kernel::down, waiting);
  };
  EXPECT_EQ(choose(counts(100, 3, 101, 0, 99)), Kernel::intersect);
  EXPECT_EQ(choose(counts(50, 0, 50, 0, 50)), Kernel::down) << "of equals the first in the flow";
}

TEST(MultipassSchedule, DrainStaysToTheLastRay) {
  EXPECT_EQ(choose_kernel(MultipassRule::drain, Kernel::down, counts(1, 1000, 0, 0, 0)), Kernel::down);
  EXPECT_EQ(choose_kernel(MultipassRule::drain, Kernel::down, counts(0, 0, 0, 4, 1000)), Kernel::continue_search);
}

// Whatever waits, a kernel that rays wait for is chosen: no pass is empty, so every traversal ends.
TEST(MultipassSchedule, NeverChoosesAKernelThatNobodyWaitsFor) {
  for (std::uint32_t n = 0; n < 20'000; ++n) {
    CounterRng rng(1, 0, n);
    MultipassCounts waiting;
    for (int k = 0; k < kMultipassKernels; ++k)
      if (rng.next_below(3) == 0) waiting[static_cast<Kernel>(k)] = rng.next_below(50);
    if (waiting.total() == 0) continue;
    const auto current = static_cast<Kernel>(rng.next_below(kMultipassKernels));
    for (const MultipassRule rule : test::kRules)
      ASSERT_GT(waiting[choose_kernel(rule, current, waiting)], 0u) << rule_name(rule);
  }
}

TEST(MultipassSchedule, RunsFromInitializeUntilNoRayIsLeft) {
  std::vector<Kernel> order;
  const auto next_of = [](Kernel kernel) { return static_cast<Kernel>(static_cast<int>(kernel) + 1); };
  const Status status = run_passes(MultipassRule::delany, 10, [&](Kernel kernel, MultipassCounts& waiting) -> Status {
    order.push_back(kernel);
    const std::uint32_t rays = waiting[kernel];
    waiting[kernel] = 0;
    if (next_of(kernel) != Kernel::finished) waiting[next_of(kernel)] = rays;
    return Done{};
  });
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(order, (std::vector<Kernel>{Kernel::initialize, Kernel::down, Kernel::leaf, Kernel::intersect,
                                        Kernel::continue_search, Kernel::up}));
}

TEST(MultipassSchedule, StopsAtTheFirstFailure) {
  int passes = 0;
  const Status status = run_passes(MultipassRule::drain, 10, [&](Kernel, MultipassCounts&) -> Status {
    ++passes;
    return Error{"broken"};
  });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.message(), "broken");
  EXPECT_EQ(passes, 1);
  EXPECT_TRUE(run_passes(MultipassRule::drain, 0, [](Kernel, MultipassCounts&) -> Status { return Error{"never run"}; }).ok());
}

}  // namespace
}  // namespace accel
