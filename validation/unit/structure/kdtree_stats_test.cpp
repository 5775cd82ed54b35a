#include "libaccel/structure/kdtree_stats.h"

#include <gtest/gtest.h>

#include <numeric>

#include "libaccel/build/kdtree_sah.h"
#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

TEST(KdTreeStats, NothingHasNoCost) {
  const KdTreeStats stats = kdtree_stats(KdTree{});
  EXPECT_EQ(stats.leaves, 0u);
  EXPECT_EQ(stats.sah_cost(1, 1), 0);
  EXPECT_EQ(stats.references_per_triangle(), 0);
}

// A cube cut at a quarter of x; below it an empty leaf, above it a cut at half of y with one triangle below and two above, one
// of them in both.
KdTree quarter_tree() {
  KdTree tree;
  const Triangle triangle{{1, 0, 0}, {4, 4, 0}, {4, 0, 4}};
  tree.nodes = Buffer<KdNode>(6);
  tree.nodes[0] = KdNode::inner(0, 1.0f, 2);
  tree.nodes[1] = KdNode::leaf(kEmptyLeaf, 0);
  tree.nodes[2] = KdNode::leaf(kEmptyLeaf, 0);
  tree.nodes[3] = KdNode::inner(1, 2.0f, 4);
  tree.nodes[4] = KdNode::leaf(0, 1);
  tree.nodes[5] = KdNode::leaf(1, 2);
  const std::uint32_t references[] = {0 | kLastReference, 0, 1 | kLastReference};
  tree.leaves.references = Buffer<std::uint32_t>::copy_of(references);
  const PackedTriangle triangles[] = {pack(triangle, 0), pack(triangle, 1)};
  tree.leaves.triangles = Buffer<PackedTriangle>::copy_of(triangles);
  tree.bounds = {{0, 0, 0}, {4, 4, 4}};
  tree.depth = 2, tree.leaf_count = 3;
  return tree;
}

TEST(KdTreeStats, AgreeWithATreeCountedByHand) {
  const KdTree tree = quarter_tree();
  ASSERT_TRUE(validate(tree, 2).ok());
  const KdTreeStats stats = kdtree_stats(tree);
  // Half areas: root 48, lower 16 + 4 + 4 = 24, upper 16 + 12 + 12 = 40, its halves 3 * 2 + 3 * 4 + 2 * 4 = 26.
  EXPECT_DOUBLE_EQ(stats.expected_steps, 1 + 40.0 / 48);
  EXPECT_DOUBLE_EQ(stats.expected_leaves, (24.0 + 26 + 26) / 48);
  EXPECT_DOUBLE_EQ(stats.expected_tests, (26.0 * 1 + 26 * 2) / 48);
  EXPECT_DOUBLE_EQ(stats.sah_cost(8, 1), 8 * stats.expected_steps + stats.expected_tests);
  EXPECT_EQ(stats.inner_nodes, 2u);
  EXPECT_EQ(stats.leaves, 3u);
  EXPECT_EQ(stats.empty_leaves, 1u);
  EXPECT_EQ(stats.triangles, 2u);
  EXPECT_EQ(stats.references, 3u);
  EXPECT_EQ(stats.references_per_triangle(), 1.5);
  EXPECT_EQ(stats.depth, 2u);
  EXPECT_DOUBLE_EQ(stats.mean_leaf_depth, 5.0 / 3);
  EXPECT_DOUBLE_EQ(stats.mean_leaf_size, 1.5);
  EXPECT_DOUBLE_EQ(stats.leaf_size_variance, 0.25);
  EXPECT_EQ(stats.leaves_by_depth, (std::vector<std::uint64_t>{0, 1, 2}));
  EXPECT_EQ(stats.leaves_by_size, (std::vector<std::uint64_t>{1, 1, 1}));
}

TEST(KdTreeStats, HistogramsAddUp) {
  for (const test::NamedMesh& named : test::all_meshes()) {
    SCOPED_TRACE(named.name);
    const KdTree tree = KdTreeSah::build(named.mesh, {}).value().structure;
    const KdTreeStats stats = kdtree_stats(tree);
    EXPECT_EQ(stats.leaves, tree.leaf_count);
    EXPECT_EQ(stats.inner_nodes + 1, stats.leaves);
    EXPECT_EQ(stats.references, tree.leaves.references.size());
    EXPECT_EQ(std::accumulate(stats.leaves_by_depth.begin(), stats.leaves_by_depth.end(), std::uint64_t{0}), stats.leaves);
    EXPECT_EQ(std::accumulate(stats.leaves_by_size.begin(), stats.leaves_by_size.end(), std::uint64_t{0}), stats.leaves);
    EXPECT_LE(stats.leaves_by_size.size(), kLargestCountedKdLeaf + 1);
    EXPECT_EQ(stats.leaves_by_depth.size(), stats.depth + 1u);
  }
}

}  // namespace
}  // namespace accel
