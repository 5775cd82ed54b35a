#include "libaccel/exec/cpu.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <vector>

#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/brute_force.h"
#include "validation/unit/exec/list_and_rays.h"

namespace accel {
namespace {

using Closest = BruteForce<Watertight, Query::closest>;
using Any = BruteForce<Watertight, Query::any>;

class Cpu : public ListAndRays {
 protected:
  std::vector<Hit> closest(int threads) const {
    std::vector<Hit> hits(rays_.size());
    trace_closest<Closest>(list_.view(), rays_, hits, threads);
    return hits;
  }
};

TEST(ForEachBlock, CoversEveryIndexOnce) {
  for (const int threads : {0, 1, 2, 4})
    for (const std::size_t count :
         {std::size_t{0}, std::size_t{1}, kRaysPerTask - 1, kRaysPerTask, kRaysPerTask + 1, 10 * kRaysPerTask + 3}) {
      std::vector<std::atomic<int>> visits(count);
      for_each_block(count, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) ++visits[i];
      });
      for (const auto& v : visits) ASSERT_EQ(v, 1) << threads << " threads, " << count;
    }
}

TEST_F(Cpu, ThreadsDoNotChangeABit) {
  const std::vector<Hit> hits = closest(1);
  for (const int threads : {2, 4, 0})
    EXPECT_EQ(std::memcmp(closest(threads).data(), hits.data(), hits.size() * sizeof(Hit)), 0) << threads;
}

TEST_F(Cpu, AnyHitIffClosestHit) {
  const std::vector<Hit> hits = closest(1);
  std::vector<std::uint8_t> occluded(rays_.size(), 2);
  trace_any<Any>(list_.view(), rays_, occluded, 2);
  for (std::size_t i = 0; i < rays_.size(); ++i) EXPECT_EQ(occluded[i], hits[i].valid() ? 1 : 0) << i;
}

}  // namespace
}  // namespace accel
