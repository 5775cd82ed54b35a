#include "libaccel/exec/cpu.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <numeric>
#include <vector>

#include "libaccel/build/triangle_list.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/brute_force.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

using Closest = BruteForce<Watertight, Query::closest>;
using Any = BruteForce<Watertight, Query::any>;

class Cpu : public testing::Test {
 protected:
  Cpu() : mesh_(validation::mesh_of(validation::random_triangles(50, 0.5f, 1))), rays_(validation::stress_rays(mesh_, 10'000)) {
    auto built = ListBuilder::build(mesh_, {});
    EXPECT_TRUE(built) << built.message();
    list_ = std::move(built->structure);
  }

  std::vector<Hit> closest(int threads) const {
    std::vector<Hit> hits(rays_.size());
    trace_closest<Closest>(list_.view(), rays_, hits, threads);
    return hits;
  }

  TriangleMesh mesh_;
  std::vector<Ray> rays_;
  TriangleList list_;
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

TEST_F(Cpu, CountersAreExactForAnyNumberOfThreads) {
  const Counters one = count_rays<Closest>(list_.view(), rays_, {}, 1), four = count_rays<Closest>(list_.view(), rays_, {}, 4);
  EXPECT_EQ(one.rays, rays_.size());
  EXPECT_EQ(one.triangle_tests, rays_.size() * mesh_.size()) << "brute force tests every triangle";
  EXPECT_EQ(one.node_steps, 0u);
  EXPECT_EQ(std::memcmp(&one, &four, sizeof one), 0);
}

TEST_F(Cpu, StepsAddUp) {
  std::vector<std::uint32_t> steps(rays_.size());
  const Counters counters = count_rays<Any>(list_.view(), rays_, steps, 2);
  std::uint64_t sum = 0;
  for (const std::uint32_t s : steps) sum += s;
  EXPECT_EQ(sum, counters.node_steps + counters.triangle_tests);
  EXPECT_LT(counters.triangle_tests, rays_.size() * mesh_.size()) << "any hit stops at the first";
}

TEST_F(Cpu, EveryCounterOfSingleRaysAddsUp) {
  std::vector<std::uint32_t> values(rays_.size());
  for (int c = 0; c < kRayCounters; ++c) {
    const auto counter = static_cast<RayCounter>(c);
    const Counters counters = count_rays<Closest>(list_.view(), rays_, values, 2, counter);
    EXPECT_EQ(std::accumulate(values.begin(), values.end(), std::uint64_t{0}), value_of(counters, counter))
        << counter_name(counter);
  }
}

}  // namespace
}  // namespace accel
