#include "libaccel/exec/count_rays.h"

#include <gtest/gtest.h>

#include <cstring>
#include <numeric>
#include <vector>

#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/brute_force.h"
#include "validation/unit/exec/list_and_rays.h"

namespace accel {
namespace {

using Closest = BruteForce<Watertight, Query::closest>;
using Any = BruteForce<Watertight, Query::any>;

class CountRays : public ListAndRays {};

TEST_F(CountRays, IsExactForAnyNumberOfThreads) {
  const Counters one = count_rays<Closest>(list_.view(), rays_, {}, 1), four = count_rays<Closest>(list_.view(), rays_, {}, 4);
  EXPECT_EQ(one.rays, rays_.size());
  EXPECT_EQ(one.triangle_tests, rays_.size() * mesh_.size()) << "brute force tests every triangle";
  EXPECT_EQ(one.node_steps, 0u);
  EXPECT_EQ(std::memcmp(&one, &four, sizeof one), 0);
}

TEST_F(CountRays, StepsAddUp) {
  std::vector<std::uint32_t> steps(rays_.size());
  const Counters counters = count_rays<Any>(list_.view(), rays_, steps, 2);
  std::uint64_t sum = 0;
  for (const std::uint32_t s : steps) sum += s;
  EXPECT_EQ(sum, counters.node_steps + counters.triangle_tests);
  EXPECT_LT(counters.triangle_tests, rays_.size() * mesh_.size()) << "any hit stops at the first";
}

TEST_F(CountRays, EveryCounterOfSingleRaysAddsUp) {
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
