#include "libaccel/trace/bvh8_ordered.h"

#include <gtest/gtest.h>

#include <vector>

#include "libaccel/build/code_bvh8.h"
#include "libaccel/build/collapse_wide.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/build/wide_sbvh.h"
#include "libaccel/exec/count_rays.h"
#include "libaccel/exec/counters.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/geometry/moeller_trumbore.h"
#include "libaccel/trace/bvh2_stack.h"
#include "validation/stress/random_bvh2.h"
#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

using Closest = Bvh8Ordered<Watertight, Query::closest>;
using Any = Bvh8Ordered<Watertight, Query::any>;

std::vector<Ray> random_rays(std::uint32_t count) {
  std::vector<Ray> rays(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    CounterRng rng(9, i);
    rays[i].org = test::random_point(rng) * 1.5f, rays[i].dir = test::random_point(rng);
  }
  return rays;
}

TEST(Bvh8Ordered, HitsAreThoseOfTheBinaryTree) {
  const TriangleMesh mesh = test::soup(3000, 0.1f);
  const Bvh2 binary = Sbvh::build(mesh, {})->structure;
  const Bvh8 wide = *collapse_wide(binary, {});
  const std::vector<Ray> rays = random_rays(2000);
  std::vector<Hit> expected(rays.size()), hits(rays.size());
  trace_closest<Bvh2Stack<Watertight, Query::closest>>(binary.view(), rays, expected, 1);
  trace_closest<Closest>(wide.view(), rays, hits, 1);
  std::size_t valid = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    valid += hits[i].valid();
    EXPECT_EQ(hits[i].t, expected[i].t) << i;
    EXPECT_EQ(hits[i].prim_id, expected[i].prim_id) << i;
  }
  EXPECT_GT(valid, 300u);
}

TEST(Bvh8Ordered, VisitsLessThanTheBinaryTree) {
  const TriangleMesh mesh = test::soup(3000, 0.1f);
  const Bvh2 binary = Sbvh::build(mesh, {})->structure;
  const Bvh8 wide = *collapse_wide(binary, {});
  const std::vector<Ray> rays = random_rays(1000);
  const Counters two = count_rays<Bvh2Stack<Watertight, Query::closest>>(binary.view(), rays, {}, 1);
  const Counters eight = count_rays<Closest>(wide.view(), rays, {}, 1);
  EXPECT_LT(3 * eight.node_steps, two.node_steps);
  EXPECT_EQ(eight.box_tests, 8 * eight.node_steps);
  // Any-hit queries stop.
  EXPECT_LT(count_rays<Any>(wide.view(), rays, {}, 1).triangle_tests, eight.triangle_tests);
}

// What is fetched: blocks of 160 bytes, or of 64 bytes with 12 for each vertex of a triangle that is tested.
TEST(Bvh8Ordered, BytesOfBlocksThatNameVertices) {
  const Bvh8 bvh = WideSbvh::build(test::soup(3000, 0.1f), {})->structure;
  const std::vector<Ray> rays = random_rays(1000);
  using Bytes = Bvh8ByteOrdered<Watertight, Query::closest>;
  using Compact = Bvh8CompactOrdered<Watertight, Query::closest>;
  const Counters whole = count_rays<Bytes>(code_bvh8<ByteBvh8Node>(bvh).view(), rays, {}, 1);
  const Counters named = count_rays<Compact>(code_bvh8<CompactBvh8Node>(bvh).view(), rays, {}, 1);
  constexpr int kTriangle = static_cast<int>(Memory::triangle), kNode = static_cast<int>(Memory::node);
  EXPECT_EQ(named.triangle_tests, whole.triangle_tests);
  EXPECT_EQ(named.bytes[kNode], whole.bytes[kNode]);
  EXPECT_EQ(named.bytes[kTriangle], whole.bytes[kTriangle] / 160 * 64 + 36 * named.triangle_tests);
}

// The chain of nodes that needs the most room: seven children postponed at each level.
TEST(Bvh8Ordered, TheStackHoldsTheDeepestTree) {
  constexpr std::uint32_t kDepth = kMostBvh8Depth;
  constexpr std::uint32_t kTriangles = 7 * kDepth + 1;
  Bvh8 bvh;
  bvh.nodes = Buffer<Bvh8Node>(kDepth);
  bvh.blocks = Buffer<TriangleBlock>(kTriangles);
  bvh.root = 0, bvh.depth = kDepth, bvh.references = kTriangles;
  const auto triangle_at = [](float z) { return Triangle{{-1, -1, z}, {3, -1, z}, {-1, 3, z}}; };
  const Aabb all{{-1, -1, 1}, {3, 3, static_cast<float>(kTriangles)}};
  bvh.bounds = all;
  for (std::uint32_t i = 0; i < kTriangles; ++i) {
    for (std::uint32_t lane = 1; lane < kBlockLanes; ++lane) bvh.blocks[i].clear(lane);
    bvh.blocks[i].set(0, pack(triangle_at(static_cast<float>(i + 1)), i));
  }
  for (std::uint32_t d = 0; d < kDepth; ++d) {
    Bvh8Node node{};
    for (std::uint32_t c = 0; c < 7; ++c) node.set_child(c, block_ref(7 * d + c, 1), all);
    node.set_child(7, d + 1 < kDepth ? d + 1 : block_ref(kTriangles - 1, 1), all);
    for (std::uint32_t i = 0; i < kBvh8Arity; ++i) node.order[i] = i * 0x249249u;  // child 7 comes first, for all octants
    bvh.nodes[d] = node;
  }
  const Status valid = validate(bvh, kTriangles);
  ASSERT_TRUE(valid) << valid.message();
  const Ray three[] = {{{0, 0, 0}, 0, {0, 0, 1}}, {{0.5f, 0.5f, 2000}, 0, {0, 0, -1}}, {{9, 9, 0}, 0, {0, 0, 1}}};
  NullObserver observer;
  for (const std::size_t times : {1, 40}) {  // one after the other, and by turns
    std::vector<Ray> rays;
    for (std::size_t i = 0; i < times; ++i) rays.insert(rays.end(), three, three + 3);
    std::vector<Hit> hits(rays.size());
    trace_bvh8_simd<Bvh8Node, PaddedSlabs, Watertight>(bvh.view(), rays, hits);
    for (std::size_t i = 0; i < rays.size(); i += 3) {
      EXPECT_EQ(trace_ray<Closest>(bvh.view(), rays[i], observer).prim_id, hits[i].prim_id);
      EXPECT_EQ(hits[i].prim_id, 0u);
      EXPECT_EQ(hits[i + 1].prim_id, kTriangles - 1);
      EXPECT_FALSE(hits[i + 2].valid());
    }
  }
}

// Batches of any size and any number of threads, and another triangle test.
TEST(Bvh8Ordered, Batches) {
  const Bvh8 bvh = WideSbvh::build(test::soup(500, 0.3f), {})->structure;
  const std::vector<Ray> rays = random_rays(3000);
  using Plain = Bvh8Ordered<MoellerTrumbore, Query::closest>;
  for (const int threads : {1, 3}) {
    std::vector<Hit> hits(rays.size()), plain(rays.size());
    std::vector<std::uint8_t> occluded(rays.size());
    trace_closest<Closest>(bvh.view(), rays, hits, threads);
    trace_any<Any>(bvh.view(), rays, occluded, threads);
    trace_closest<Plain>(bvh.view(), rays, plain, threads);
    NullObserver observer;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Hit expected = trace_ray<Closest>(bvh.view(), rays[i], observer);
      EXPECT_EQ(hits[i].prim_id, expected.prim_id);
      EXPECT_EQ(hits[i].t, expected.t);
      EXPECT_EQ(occluded[i] != 0, expected.valid());
      EXPECT_EQ(plain[i].prim_id, trace_ray<Plain>(bvh.view(), rays[i], observer).prim_id);
    }
  }
  std::vector<Hit> none;
  trace_closest<Closest>(bvh.view(), {}, none, 0);
}

}  // namespace
}  // namespace accel
