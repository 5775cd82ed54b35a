#include "libaccel/structure/bvh8.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "libaccel/build/coded_wide_sbvh.h"
#include "libaccel/build/wide_sbvh.h"
#include "libaccel/core/counter_rng.h"
#include "libaccel/exec/drive.h"
#include "libaccel/structure/bvh8_stats.h"
#include "libaccel/trace/bvh8_ordered.h"
#include "validation/unit/build/test_meshes.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

constexpr std::uint64_t kBvh8Triangles = 300;

// A fresh valid tree.
Bvh8 valid_bvh8() {
  Result<Built<Bvh8>> built = WideSbvh::build(test::soup(kBvh8Triangles, 0.2f), {});
  EXPECT_TRUE(built.ok());
  return std::move(built->structure);
}

// What validate() says about a tree that `corrupt` has changed; empty when it finds nothing.
std::string complaint(const std::function<void(Bvh8&)>& corrupt) {
  Bvh8 bvh = valid_bvh8();
  corrupt(bvh);
  const Status status = validate(bvh, kBvh8Triangles);
  return status ? "" : status.message();
}

// The first child reference that is a leaf, or an inner node.
NodeRef& find_child(Bvh8& bvh, bool leaf) {
  for (Bvh8Node& node : bvh.nodes)
    for (NodeRef& child : node.child)
      if (child != kNoNode && is_leaf(child) == leaf) return child;
  ADD_FAILURE();
  return bvh.root;
}

// The first block with room left.
TriangleBlock& find_open_block(Bvh8& bvh) {
  for (TriangleBlock& block : bvh.blocks)
    if (block.has(0) && !block.has(kBlockLanes - 1)) return block;
  ADD_FAILURE();
  return bvh.blocks[0];
}

// The first node with fewer than eight children.
Bvh8Node& find_open_node(Bvh8& bvh) {
  for (Bvh8Node& node : bvh.nodes)
    if (node.child[kBvh8Arity - 1] == kNoNode) return node;
  ADD_FAILURE();
  return bvh.nodes[0];
}

TEST(ValidateBvh8, AcceptsTreesAndTheEmptyTree) {
  EXPECT_EQ(complaint([](Bvh8&) {}), "");
  EXPECT_TRUE(validate(Bvh8{}, 0).ok());
}

TEST(ValidateBvh8, References) {
  EXPECT_NE(complaint([](Bvh8& b) { find_child(b, false) = static_cast<NodeRef>(b.nodes.size()); }), "");
  EXPECT_NE(complaint([](Bvh8& b) { find_child(b, false) = kNoNode; }), "");
  EXPECT_NE(complaint([](Bvh8& b) { find_child(b, true) = block_ref(static_cast<std::uint32_t>(b.blocks.size()), 1); }), "");
  EXPECT_NE(complaint([](Bvh8& b) { find_child(b, true) += 1; }), "");
  EXPECT_NE(complaint([](Bvh8& b) { find_child(b, true) = find_child(b, false); }), "");
  EXPECT_NE(complaint([](Bvh8& b) { b.root = kNoNode; }), "");
  EXPECT_NE(complaint([](Bvh8& b) { b.root = 0x7fffffffu; }), "");
  EXPECT_NE(complaint([](Bvh8& b) { b.root = b.nodes[0].child[0]; }), "");
}

TEST(ValidateBvh8, LeavesThatCountWrong) {
  for (std::uint32_t count = 0; count < 8; ++count)
    EXPECT_NE(complaint([&](Bvh8& b) {
                NodeRef& leaf = find_child(b, true);
                const std::uint32_t right = counted_blocks(leaf);
                leaf = kLeafBit | (count == right ? right + 1 : count) << kBlockBits | first_block(leaf);
              }),
              "")
        << count;
}

TEST(ValidateBvh8, CyclesAndSharedNodes) {
  EXPECT_NE(complaint([](Bvh8& b) { find_child(b, false) = b.root; }), "");
  EXPECT_NE(complaint([](Bvh8& b) { b.nodes[b.nodes.size() - 1].child[0] = 0; }), "");
  EXPECT_NE(complaint([](Bvh8& b) { b.nodes[0].child[0] = b.nodes[0].child[1]; }), "");
}

TEST(ValidateBvh8, UnreachableNodesAndBlocks) {
  EXPECT_NE(complaint([](Bvh8& b) {
              Buffer<Bvh8Node> more(b.nodes.size() + 1);
              std::copy(b.nodes.begin(), b.nodes.end(), more.begin());
              more[b.nodes.size()] = b.nodes[0];
              b.nodes = more;
            }),
            "");
  EXPECT_NE(complaint([](Bvh8& b) { b.nodes.truncate(b.nodes.size() - 1); }), "");
  EXPECT_NE(complaint([](Bvh8& b) { b.blocks.truncate(b.blocks.size() - 1); }), "");
}

TEST(ValidateBvh8, Planes) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) {
      EXPECT_NE(complaint([&](Bvh8& b) { b.nodes[b.nodes.size() / 2].planes[axis][side][0] = nan; }), "");
      EXPECT_NE(complaint([&](Bvh8& b) { b.nodes[b.nodes.size() - 1].planes[axis][side][0] += side == 0 ? -3.0f : 3.0f; }), "")
          << "outside of its parent's";
      EXPECT_NE(complaint([&](Bvh8& b) { find_open_node(b).planes[axis][side][kBvh8Arity - 1] = 0; }), "") << "of no child";
    }
  EXPECT_NE(complaint([](Bvh8& b) { std::swap(b.nodes[0].planes[1][0][1], b.nodes[0].planes[1][1][1]); }), "");
  EXPECT_NE(complaint([&](Bvh8& b) { b.bounds.lo.z = nan; }), "");
}

TEST(ValidateBvh8, Children) {
  EXPECT_NE(complaint([](Bvh8& b) {
              Bvh8Node& node = find_open_node(b);
              node.set_child(kBvh8Arity - 1, node.child[0], node.bounds(0));
              const Bvh8Node copy = node;
              node.set_child(0, kNoNode, copy.bounds(kBvh8Arity - 2));
            }),
            "");
  EXPECT_NE(complaint([](Bvh8& b) { b.nodes[0].order[3] ^= 1u; }), "") << "no permutation";
  EXPECT_NE(complaint([](Bvh8& b) { b.nodes[0].order[0] = b.nodes[0].order[1]; }), "");
}

TEST(ValidateBvh8, Triangles) {
  EXPECT_NE(complaint([](Bvh8& b) { b.blocks[0].prim_id[0] = kBvh8Triangles; }), "");
  EXPECT_NE(complaint([](Bvh8& b) { b.blocks[0].clear(0); }), "");
  EXPECT_NE(complaint([](Bvh8& b) { find_open_block(b).prim_id[kBlockLanes - 1] = 0; }), "") << "a gap, or one too many";
  EXPECT_NE(complaint([](Bvh8& b) { find_open_block(b).vertex[2][1][kBlockLanes - 1] = 0; }), "") << "no prim_id";
}

TEST(ValidateBvh8, Counts) {
  EXPECT_NE(complaint([](Bvh8& b) { b.depth += 1; }), "");
  EXPECT_NE(complaint([](Bvh8& b) { b.depth -= 1; }), "");
  EXPECT_NE(complaint([](Bvh8& b) { b.references += 1; }), "");
}

// Whatever is damaged, validate() returns, and what it accepts can be traversed.
TEST(ValidateBvh8, SurvivesRandomDamage) {
  CounterRng rng(7, 0);
  std::size_t accepted = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    Bvh8 bvh = valid_bvh8();
    Bvh8::for_each_array(bvh, [&](std::string_view, auto& array) {
      auto* const words = reinterpret_cast<std::uint32_t*>(array.data());
      const auto size = static_cast<std::uint32_t>(array.size_bytes() / 4);
      if (rng.next_below(2) == 0) words[rng.next_below(size)] ^= 1u << rng.next_below(32);
    });
    if (!validate(bvh, kBvh8Triangles)) continue;
    ++accepted;
    NullObserver observer;
    const Hit hit = trace_ray<Bvh8Ordered<Watertight, Query::closest>>(bvh.view(), {{-3, 0.1f, 0.2f}, 0, {1, 0, 0}}, observer);
    EXPECT_TRUE(!hit.valid() || hit.prim_id < kBvh8Triangles);
  }
  EXPECT_GT(accepted, 100u);
}

// What validate() says about a compact tree that `corrupt` has changed.
std::string compact_complaint(const std::function<void(Bvh8Compact&)>& corrupt) {
  Bvh8Compact bvh = CompactWideSbvh::build(test::soup(kBvh8Triangles, 0.2f), {})->structure;
  corrupt(bvh);
  const Status status = validate(bvh, kBvh8Triangles);
  return status ? "" : status.message();
}

TEST(ValidateBvh8Compact, Vertices) {
  constexpr std::uint32_t kLast = kBlockLanes - 1;
  const auto open_block = [](Bvh8Compact& b) -> IndexedBlock& {
    return *std::find_if(b.blocks.begin(), b.blocks.end(), [](const IndexedBlock& block) { return !block.has(kLast); });
  };
  const auto size = [](const Bvh8Compact& b) { return static_cast<std::uint32_t>(b.vertices.size()); };
  EXPECT_EQ(compact_complaint([](Bvh8Compact&) {}), "");
  EXPECT_EQ(compact_complaint([&](Bvh8Compact& b) { b.blocks[3].vertex[1][0] = size(b) - 2; }), "") << "any that can be read";
  EXPECT_NE(compact_complaint([&](Bvh8Compact& b) { b.blocks[3].vertex[1][0] = size(b) - 1; }), "") << "the last, which cannot";
  EXPECT_NE(compact_complaint([&](Bvh8Compact& b) { b.blocks[3].vertex[2][0] = size(b); }), "");
  EXPECT_NE(compact_complaint([&](Bvh8Compact& b) { b.blocks[3].vertex[0][0] = 0xffffffffu; }), "");
  EXPECT_NE(compact_complaint([&](Bvh8Compact& b) { open_block(b).vertex[0][kLast] = 0xffffffffu; }), "") << "of no triangle";
  EXPECT_NE(compact_complaint([&](Bvh8Compact& b) { open_block(b).vertex[0][kLast] = open_block(b).vertex[0][0]; }), "")
      << "not NaN";
  EXPECT_NE(compact_complaint([&](Bvh8Compact& b) { b.vertices[open_block(b).vertex[1][kLast]].y = 0; }), "");
  EXPECT_NE(compact_complaint([&](Bvh8Compact& b) { open_block(b).prim_id[kLast] = kBvh8Triangles; }), "");
  EXPECT_NE(compact_complaint([](Bvh8Compact& b) { b.vertices.truncate(b.vertices.size() - 1); }), "");
  EXPECT_NE(compact_complaint([](Bvh8Compact& b) { b.vertices = {}; }), "");
  EXPECT_TRUE(validate(Bvh8Compact{}, 0).ok());
}

TEST(ValidateBvh8Compact, SurvivesRandomDamage) {
  const Bvh8Compact intact = CompactWideSbvh::build(test::soup(kBvh8Triangles, 0.2f), {})->structure;
  CounterRng rng(8, 0);
  std::size_t accepted = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    Bvh8Compact bvh = intact;
    Bvh8Compact::for_each_array(bvh, [&](std::string_view, auto& array) {
      array = std::decay_t<decltype(array)>::copy_of(array.span());
      auto* const words = reinterpret_cast<std::uint32_t*>(array.data());
      const auto size = static_cast<std::uint32_t>(array.size_bytes() / 4);
      if (rng.next_below(2) == 0) words[rng.next_below(size)] ^= 1u << rng.next_below(32);
    });
    if (!validate(bvh, kBvh8Triangles)) continue;
    ++accepted;
    const std::vector<Ray> rays(9, {{-3, 0.1f, 0.2f}, 0, {1, 0, 0}});
    std::vector<Hit> hits(rays.size());
    trace_bvh8_simd<CompactBvh8Node, PaddedSlabs, Watertight>(bvh.view(), rays, hits);
    EXPECT_TRUE(!hits[0].valid() || hits[0].prim_id < kBvh8Triangles);
  }
  EXPECT_GT(accepted, 100u);
}

// A chain of a million nodes: neither validate() nor the statistics may recurse.
TEST(ValidateBvh8, ALongChainDoesNotOverflowTheStack) {
  constexpr std::uint32_t kLength = 1000000;
  const Triangle triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Bvh8 small = WideSbvh::build(test::soup(40, 0.1f), {.max_leaf_size = 1})->structure;
  Bvh8Node node = small.nodes[0];
  for (std::uint32_t c = 0; c < kBvh8Arity; ++c)
    node.set_child(c, kNoNode, {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}});
  Bvh8 bvh;
  bvh.nodes = Buffer<Bvh8Node>(kLength);
  bvh.blocks = Buffer<TriangleBlock>(1);
  for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane) bvh.blocks[0].clear(lane);
  bvh.blocks[0].set(0, pack(triangle, 0));
  for (std::uint32_t i = 0; i < kLength; ++i) {
    bvh.nodes[i] = node;
    bvh.nodes[i].set_child(0, i + 1 < kLength ? i + 1 : block_ref(0, 1), triangle.bounds());
  }
  bvh.root = 0, bvh.bounds = triangle.bounds(), bvh.depth = kLength, bvh.references = 1;
  const Status valid = validate(bvh, 1);
  EXPECT_TRUE(valid.ok()) << valid.message();
  EXPECT_EQ(bvh8_stats(bvh, 1, 1).depth, kLength);
}

}  // namespace
}  // namespace accel
