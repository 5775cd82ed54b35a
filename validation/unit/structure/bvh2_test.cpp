#include "libaccel/structure/bvh2.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "libaccel/build/binned_sah.h"
#include "libaccel/structure/bvh2_stats.h"
#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

constexpr std::uint64_t kTriangles = 200;

// A fresh valid tree.
Bvh2 valid_tree() {
  Result<Built<Bvh2>> built = BinnedSah::build(test::soup(kTriangles, 0.2f), {});
  EXPECT_TRUE(built.ok());
  return std::move(built->structure);
}

// What validate() says about a tree that `corrupt` has changed; empty when it finds nothing.
std::string complaint(const std::function<void(Bvh2&)>& corrupt) {
  Bvh2 bvh = valid_tree();
  corrupt(bvh);
  const Status status = validate(bvh, kTriangles);
  return status ? "" : status.message();
}

// The first child reference that is a leaf, or an inner node.
NodeRef& find_child(Bvh2& bvh, bool leaf) {
  for (Bvh2Node& node : bvh.nodes)
    for (NodeRef& child : node.child)
      if (is_leaf(child) == leaf) return child;
  ADD_FAILURE();
  return bvh.root;
}

TEST(ValidateBvh2, AcceptsTreesAndTheEmptyTree) {
  EXPECT_EQ(complaint([](Bvh2&) {}), "");
  EXPECT_TRUE(validate(Bvh2{}, 0).ok());
}

TEST(ValidateBvh2, References) {
  EXPECT_NE(complaint([](Bvh2& b) { find_child(b, false) = static_cast<NodeRef>(b.nodes.size()); }), "");
  EXPECT_NE(complaint([](Bvh2& b) { find_child(b, false) = kNoNode; }), "");
  EXPECT_NE(complaint([](Bvh2& b) { find_child(b, true) = leaf_ref(static_cast<std::uint32_t>(b.leaves.size())); }), "");
  EXPECT_NE(complaint([](Bvh2& b) { find_child(b, true) += 1; }), "");
  EXPECT_NE(complaint([](Bvh2& b) { find_child(b, true) = find_child(b, false); }), "");
  EXPECT_NE(complaint([](Bvh2& b) { b.root = kNoNode; }), "");
  EXPECT_NE(complaint([](Bvh2& b) { b.root = 0x7fffffffu; }), "");
  EXPECT_NE(complaint([](Bvh2& b) { b.root = b.nodes[0].child[0]; }), "");
}

TEST(ValidateBvh2, CyclesAndSharedNodes) {
  EXPECT_NE(complaint([](Bvh2& b) { find_child(b, false) = b.root; }), "");
  EXPECT_NE(complaint([](Bvh2& b) { b.nodes[b.nodes.size() - 1].child[0] = 0; }), "");
  EXPECT_NE(complaint([](Bvh2& b) { b.nodes[0].child[0] = b.nodes[0].child[1]; }), "");
}

TEST(ValidateBvh2, UnreachableNodesAndLeaves) {
  EXPECT_NE(complaint([](Bvh2& b) {
              Buffer<Bvh2Node> more(b.nodes.size() + 1);
              std::copy(b.nodes.begin(), b.nodes.end(), more.begin());
              more[b.nodes.size()] = b.nodes[0];
              b.nodes = more;
            }),
            "");
  EXPECT_NE(complaint([](Bvh2& b) { b.root = find_child(b, true); }), "");
}

TEST(ValidateBvh2, Planes) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int axis = 0; axis < 3; ++axis)
    for (int plane = 0; plane < 4; ++plane)
      EXPECT_NE(complaint([&](Bvh2& b) { b.nodes[b.nodes.size() / 2].planes[axis][plane] = nan; }), "");
  EXPECT_NE(complaint([](Bvh2& b) { std::swap(b.nodes[0].planes[1][1], b.nodes[0].planes[1][3]); }), "");
  EXPECT_NE(complaint([&](Bvh2& b) { b.bounds.lo.z = nan; }), "");
}

TEST(ValidateBvh2, Leaves) {
  const auto last = [](Bvh2& b) -> LeafQuad& { return b.leaves[b.leaves.size() - 1]; };
  EXPECT_NE(complaint([&](Bvh2& b) { last(b).word = 0; }), "");
  EXPECT_NE(complaint([](Bvh2& b) { b.leaves.truncate(b.leaves.size() - 1); }), "");
  EXPECT_NE(complaint([](Bvh2& b) { b.leaves[0].word = kTriangles; }), "");
  EXPECT_NE(complaint([](Bvh2& b) { b.leaves[0].word = kEndOfLeaf; }), "");
}

TEST(ValidateBvh2, Counts) {
  EXPECT_NE(complaint([](Bvh2& b) { b.depth += 1; }), "");
  EXPECT_NE(complaint([](Bvh2& b) { b.depth -= 1; }), "");
  EXPECT_NE(complaint([](Bvh2& b) { b.references += 1; }), "");
}

// A chain of a million nodes: neither validate() nor the statistics may recurse.
Bvh2 chain(std::uint32_t length) {
  Bvh2 bvh;
  bvh.nodes = Buffer<Bvh2Node>(length);
  bvh.leaves = Buffer<LeafQuad>(4 * (length + 1));
  const Triangle triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (std::uint32_t i = 0; i <= length; ++i) {
    const PackedTriangle packed = pack(triangle, i);
    std::copy_n(reinterpret_cast<const LeafQuad*>(&packed), 3, &bvh.leaves[4 * i]);
    bvh.leaves[4 * i + 3] = {{0, 0, 0}, kEndOfLeaf};
  }
  for (std::uint32_t i = 0; i < length; ++i) {
    Bvh2Node node{};
    for (int c = 0; c < 2; ++c) node.set_bounds(c, triangle.bounds());
    node.child[0] = leaf_ref(4 * i);
    node.child[1] = i + 1 < length ? i + 1 : leaf_ref(4 * length);
    bvh.nodes[i] = node;
  }
  bvh.root = 0, bvh.bounds = triangle.bounds(), bvh.depth = length, bvh.references = length + 1;
  return bvh;
}

TEST(ValidateBvh2, ALongChainDoesNotOverflowTheStack) {
  const Bvh2 bvh = chain(1000000);
  EXPECT_TRUE(validate(bvh, 1000001).ok());
  EXPECT_EQ(bvh2_stats(bvh, 1, 1).depth, 1000000u);
}

}  // namespace
}  // namespace accel
