#include "libaccel/build/kdtree_layout.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace accel {
namespace {

constexpr Aabb kCube = {{0, 0, 0}, {1, 1, 1}};

// Halves along x only, `levels` of them: every node of a level has the same cell size.
KdNode halves(float lo, float hi, int levels, std::vector<KdNode>& nodes) {
  if (levels == 0) return KdNode::leaf(kEmptyLeaf, 0);
  const std::size_t pair = nodes.size();
  nodes.resize(pair + 2);
  const float middle = (lo + hi) / 2;
  const KdNode lower = halves(lo, middle, levels - 1, nodes), upper = halves(middle, hi, levels - 1, nodes);
  nodes[pair] = lower, nodes[pair + 1] = upper;
  return KdNode::inner(0, middle, static_cast<std::uint32_t>(pair));
}

TEST(KdTreeLayout, ParentsStayInFrontOfTheirChildren) {
  for (const std::uint64_t first_pair : {1u, 2u, 3u, 4u}) {
    std::vector<KdNode> nodes;
    const KdNode root = halves(0, 1, 9, nodes);
    const std::vector<std::uint32_t> places = clustered_pairs(nodes, root, kCube, first_pair);
    std::vector<std::uint32_t> sorted = places;
    std::sort(sorted.begin(), sorted.end());
    for (std::uint32_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i);
    EXPECT_EQ(places[0], 0u);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i].is_leaf()) continue;
      EXPECT_LT(places[i / 2], places[pair_of(nodes[i].lower_child())]);
    }
  }
}

// Paths through a chain meet a new line every fourth pair.
TEST(KdTreeLayout, ALineHoldsAPathOfFourPairs) {
  std::vector<KdNode> nodes(2 * 40, KdNode::leaf(kEmptyLeaf, 0));
  for (std::uint32_t i = 0; i + 1 < 40; ++i) nodes[2 * i] = KdNode::inner(0, 1.0f / static_cast<float>(i + 2), 2 * (i + 1));
  const std::vector<std::uint32_t> places = clustered_pairs(nodes, KdNode::inner(0, 0.99f, 0), kCube, 4);
  for (std::uint32_t i = 0; i < 40; ++i) EXPECT_EQ(places[i], i);
}

// The larger child's children are nearer.
TEST(KdTreeLayout, LikelierPairsComeFirst) {
  const KdNode leaf = KdNode::leaf(kEmptyLeaf, 0);
  const std::vector<KdNode> nodes = {KdNode::inner(1, 0.5f, 2), KdNode::inner(1, 0.5f, 4), leaf, leaf, leaf, leaf};
  EXPECT_EQ(clustered_pairs(nodes, KdNode::inner(0, 0.9f, 0), kCube, 1), (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(clustered_pairs(nodes, KdNode::inner(0, 0.1f, 0), kCube, 1), (std::vector<std::uint32_t>{0, 2, 1}));
}

TEST(KdTreeLayout, ALeafHasNoPairs) { EXPECT_TRUE(clustered_pairs({}, KdNode::leaf(kEmptyLeaf, 0), kCube, 1).empty()); }

}  // namespace
}  // namespace accel
