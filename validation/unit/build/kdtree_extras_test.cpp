// Links and ropes against their definitions, on trees that no builder makes.
#include "libaccel/build/kdtree_extras.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include <tbb/task_arena.h>

#include "libaccel/build/kdtree_walk.h"
#include "validation/stress/random_kdtrees.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

using validation::mesh_of;
using validation::random_kdtree;
using validation::random_triangles;

std::vector<KdTree> trees() {
  std::vector<KdTree> result;
  for (const std::uint64_t seed : {1, 2, 3, 4})
    result.push_back(random_kdtree(mesh_of(random_triangles(60, 0.2f, seed)), seed, {.max_nodes = 1500}));
  result.push_back(random_kdtree(mesh_of(random_triangles(3, 0.2f, 5)), 5, {.max_depth = 0}));  // the root is a leaf
  return result;
}

// The cell of every node, by definition.
std::vector<Aabb> cells_of(const KdTree& tree) {
  std::vector<Aabb> cells(tree.nodes.size());
  cells[kKdRoot] = tree.bounds;
  for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
    const KdNode node = tree.nodes[i];
    if (i == 1 || node.is_leaf()) continue;
    for (std::uint32_t side = 0; side < 2; ++side) cells[node.lower_child() + side] = part_of(cells[i], node, side);
  }
  return cells;
}

bool equal(const Aabb& a, const Aabb& b) { return a.lo == b.lo && a.hi == b.hi; }

TEST(KdTreeLinks, NameParentsAndTheirCells) {
  for (KdTree tree : trees()) {
    add_links(tree);
    const std::vector<Aabb> cells = cells_of(tree);
    ASSERT_EQ(tree.parents.size(), tree.nodes.size() / 2);
    ASSERT_EQ(tree.cells.size(), tree.nodes.size() / 2);
    for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
      if (i == 1 || tree.nodes[i].is_leaf()) continue;
      for (std::uint32_t side = 0; side < 2; ++side) {
        const std::uint32_t pair = pair_of(tree.nodes[i].lower_child() + side);
        EXPECT_EQ(tree.parents[pair], i);
        EXPECT_TRUE(equal(tree.cells[pair], cells[i]));
      }
    }
  }
}

// Whether `leaf` lies behind a face of `cell`, and they share more than an edge.
bool is_behind(const Aabb& cell, int face, const Aabb& leaf) {
  const int axis = face % 3;
  if (face < 3 ? leaf.hi[axis] != cell.lo[axis] : leaf.lo[axis] != cell.hi[axis]) return false;
  for (int a = 0; a < 3; ++a)
    if (a != axis && !(leaf.lo[a] < cell.hi[a] && leaf.hi[a] > cell.lo[a])) return false;
  return true;
}

// The leaves of a subtree, by ordinal.
std::vector<bool> leaves_below(const KdTree& tree, std::uint32_t root) {
  std::vector<bool> result(tree.leaf_count);
  std::vector<std::uint32_t> pending{root};
  while (!pending.empty()) {
    const KdNode node = tree.nodes[pending.back()];
    pending.pop_back();
    if (node.is_leaf())
      result[node.ordinal()] = true;
    else
      pending.insert(pending.end(), {node.lower_child(), node.lower_child() + 1});
  }
  return result;
}

bool contains(const std::vector<bool>& all, const std::vector<bool>& some) {
  for (std::size_t i = 0; i < some.size(); ++i)
    if (some[i] && !all[i]) return false;
  return true;
}

TEST(KdTreeRopes, NameTheSmallestSubtreeBehindEachFace) {
  for (KdTree tree : trees()) {
    add_ropes(tree);
    const std::vector<Aabb> cells = cells_of(tree);
    ASSERT_EQ(tree.ropes.size(), tree.leaf_count);
    std::vector<std::vector<bool>> below;
    for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) below.push_back(i == 1 ? std::vector<bool>() : leaves_below(tree, i));
    for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
      if (i == 1 || !tree.nodes[i].is_leaf()) continue;
      const LeafRopes& ropes = tree.ropes[tree.nodes[i].ordinal()];
      ASSERT_TRUE(equal(ropes.cell, cells[i]));
      for (int face = 0; face < 6; ++face) {
        std::vector<bool> neighbours(tree.leaf_count);
        bool any = false;
        for (std::uint32_t j = 0; j < tree.nodes.size(); ++j)
          if (j != 1 && tree.nodes[j].is_leaf() && is_behind(cells[i], face, cells[j]))
            any = neighbours[tree.nodes[j].ordinal()] = true;
        const std::uint32_t rope = ropes.rope[face];
        ASSERT_EQ(any, rope != kNoRope);
        if (!any) continue;
        EXPECT_TRUE(contains(below[rope], neighbours));
        if (tree.nodes[rope].is_leaf()) continue;
        const std::uint32_t lower = tree.nodes[rope].lower_child();
        EXPECT_FALSE(contains(below[lower], neighbours)) << "a smaller subtree would do";
        EXPECT_FALSE(contains(below[lower + 1], neighbours)) << "a smaller subtree would do";
      }
    }
  }
}

TEST(KdTreeExtras, AreTheSameForAnyNumberOfThreads) {
  const KdTree tree = random_kdtree(mesh_of(random_triangles(2000, 0.05f, 6)), 6, {.max_depth = 20, .max_nodes = 100000});
  const auto annotated = [&](int threads) {
    KdTree copy = tree;
    tbb::task_arena(threads).execute([&] { add_links(copy), add_ropes(copy); });
    return copy;
  };
  const KdTree one = annotated(1), four = annotated(4);
  const auto same = [](const auto& a, const auto& b) { return std::memcmp(a.data(), b.data(), a.size_bytes()) == 0; };
  EXPECT_TRUE(same(one.parents, four.parents));
  EXPECT_TRUE(same(one.cells, four.cells));
  EXPECT_TRUE(same(one.ropes, four.ropes));
}

TEST(KdTreeExtras, OfNothingAreNothing) {
  KdTree empty;
  add_links(empty), add_ropes(empty);
  EXPECT_EQ(empty.size_bytes(), 0u);
}

// A chain as deep as it has nodes does not overflow the call stack.
TEST(KdTreeExtras, OfAVeryDeepTree) {
  constexpr std::uint32_t kDepth = 200'000;
  KdTree tree;
  tree.bounds = {{0, 0, 0}, {1, 1, 1}};
  tree.nodes = Buffer<KdNode>(2 * kDepth + 2);
  tree.nodes[1] = KdNode::leaf(kEmptyLeaf, 0);
  for (std::uint32_t i = 0; i < kDepth; ++i) {
    tree.nodes[i == 0 ? 0 : 2 * i + 1] = KdNode::inner(0, 1 - 1e-6f * static_cast<float>(i + 1), 2 * i + 2);
    tree.nodes[2 * i + 2] = KdNode::leaf(kEmptyLeaf, i);
  }
  tree.nodes[2 * kDepth + 1] = KdNode::leaf(kEmptyLeaf, kDepth);
  tree.depth = kDepth, tree.leaf_count = kDepth + 1;
  add_links(tree), add_ropes(tree);
  EXPECT_EQ(tree.parents.size(), kDepth + 1);
  EXPECT_EQ(tree.ropes.size(), kDepth + 1);
}

}  // namespace
}  // namespace accel
