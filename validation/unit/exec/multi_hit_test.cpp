#include "libaccel/exec/multi_hit.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "libaccel/build/sbvh.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/bvh2_stack.h"
#include "validation/oracle/brute_hits.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

using Collecting = Bvh2Stack<Collect<Watertight>, Query::closest>;

class TraceHits : public testing::Test {
 protected:
  TraceHits()
      : mesh_(validation::mesh_of(validation::random_triangles(300, 0.7f, 1))), rays_(validation::stress_rays(mesh_, 3000)) {
    auto built = Sbvh::build(mesh_, {.max_leaf_size = 1});
    EXPECT_TRUE(built) << built.message();
    bvh_ = std::move(built->structure);
  }

  struct Answer {
    std::vector<Hit> hits;
    std::vector<std::uint32_t> counts;
  };
  Answer trace(std::size_t k, int threads = 1, const std::vector<Hit>& after = {}) const {
    Answer a{std::vector<Hit>(rays_.size() * k), std::vector<std::uint32_t>(rays_.size(), 77)};
    trace_hits<Collecting>(bvh_.view(), rays_, after, a.hits, a.counts, threads);
    return a;
  }
  static bool same(const Answer& a, const Answer& b) {
    return a.counts == b.counts && std::memcmp(a.hits.data(), b.hits.data(), a.hits.size() * sizeof(Hit)) == 0;
  }

  TriangleMesh mesh_;
  std::vector<Ray> rays_;
  Bvh2 bvh_;
};

TEST_F(TraceHits, HaveTrianglesInSeveralLeaves) {
  EXPECT_GT(bvh_.references, mesh_.size()) << "the tests would say nothing about duplicates";
}

TEST_F(TraceHits, AreThePrefixOfAllHits) {
  std::size_t different = 0, most = 0;
  for (const std::size_t k : {1u, 3u, 16u, 1000u}) {
    const Answer a = trace(k);
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      std::vector<Hit> expected = validation::all_hits<Watertight>(mesh_, rays_[i]);
      most = std::max(most, expected.size());
      const bool fits = a.counts[i] == std::min(k, expected.size());
      expected.resize(k);
      different += !fits || std::memcmp(expected.data(), a.hits.data() + i * k, k * sizeof(Hit)) != 0;
    }
  }
  EXPECT_LE(different, 4 * rays_.size() / 1000) << "rounding moves few hits out of their boxes";
  EXPECT_GT(most, 20u) << "the rays would say nothing";
}

TEST_F(TraceHits, GoOnBehindAHit) {
  const std::size_t k = 5;
  const Answer all = trace(4 * k);
  std::vector<Hit> after(rays_.size(), Hit{.t = kBeforeAllHits.t});
  for (std::size_t part = 0; part < 4; ++part) {
    const Answer some = trace(k, 1, after);
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      EXPECT_EQ(std::memcmp(&some.hits[i * k], &all.hits[i * 4 * k + part * k], k * sizeof(Hit)), 0) << i;
      after[i] = some.hits[i * k + k - 1];
    }
  }
}

TEST_F(TraceHits, NothingIsBehindAMiss) {
  for (const std::uint32_t count : trace(3, 1, std::vector<Hit>(rays_.size())).counts) EXPECT_EQ(count, 0u);
}

TEST_F(TraceHits, NoRoomIsNoHits) {
  for (const std::uint32_t count : trace(0).counts) EXPECT_EQ(count, 0u);
}

TEST_F(TraceHits, DoNotDependOnTheNumberOfThreads) {
  const Answer one = trace(4);
  for (const int threads : {2, 4, 0}) EXPECT_TRUE(same(trace(4, threads), one)) << threads;
}

}  // namespace
}  // namespace accel
