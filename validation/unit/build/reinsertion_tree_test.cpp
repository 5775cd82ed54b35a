// What moves do to a tree, and that the search finds the best of them: against all that there are.
#include "libaccel/build/reinsertion_tree.h"

#include <gtest/gtest.h>

#include "libaccel/build/binned_sah.h"
#include "libaccel/build/reinsertion_search.h"
#include "libaccel/build/sbvh.h"
#include "validation/unit/build/builder_checks.h"
#include "validation/unit/build/bvh2_shapes.h"

namespace accel {
namespace {

using test::build;

// As bvh2_stats() would count them, the root by its children.
double inner_area_of(const Bvh2& bvh) {
  double area = 0;
  std::vector<NodeRef> pending{bvh.root};
  while (!pending.empty()) {
    const Bvh2Node& node = bvh.nodes[pending.back()];
    pending.pop_back();
    Aabb box = node.bounds(0);
    box.extend(node.bounds(1));
    area += half_area_in_double(box);
    for (const NodeRef child : node.child)
      if (!is_leaf(child)) pending.push_back(child);
  }
  return area;
}

// Trees take the nodes that they are given; these are for one each.
Bvh2 copy_of(const Bvh2& bvh) {
  Bvh2 copy = bvh;
  copy.nodes = Buffer<Bvh2Node>::copy_of(bvh.nodes.span());
  return copy;
}

std::vector<NodeRef> all_refs(std::uint32_t nodes) {
  std::vector<NodeRef> refs;
  for (std::uint32_t i = 0; i < nodes; ++i) refs.push_back(i);
  for (std::uint32_t i = 0; i <= nodes; ++i) refs.push_back(leaf_ref(i));
  return refs;
}

TEST(ReinsertionTree, GivesBackWhatItTook) {
  const Bvh2 bvh = build<BinnedSah>(test::soup(3000, 0.05f)).structure;
  Bvh2 copy = copy_of(bvh);
  ReinsertionTree tree(copy, 120);
  EXPECT_EQ(tree.inner_area(), tree.inner_area_before());
  tree.give_back(copy);
  EXPECT_TRUE(test::same_bytes(bvh, copy));
}

TEST(ReinsertionTree, AnyMovesKeepATreeValidTightAndWithinItsLevels) {
  const TriangleMesh mesh = test::slivers(200);
  for (Bvh2 bvh : {build<Sbvh>(mesh).structure, test::shuffled(build<Sbvh>(mesh).structure)}) {
    bvh = copy_of(bvh);
    const std::uint32_t levels = bvh.depth + 1;
    ReinsertionTree tree(bvh, levels);
    const std::vector<NodeRef> refs = all_refs(tree.node_count());
    int moves = 0;
    for (std::uint32_t i = 0; i < 100000; ++i) {
      CounterRng rng(8, i);
      const auto any = [&] { return refs[rng.next_below(static_cast<std::uint32_t>(refs.size()))]; };
      const NodeRef subtree = any(), target = any();
      const double before = tree.inner_area();
      const bool moved = tree.improve(subtree, target);
      moves += moved ? 1 : 0;
      ASSERT_EQ(moved, tree.inner_area() < before);
    }
    EXPECT_GT(moves, 50);
    const double area = tree.inner_area();
    EXPECT_LT(area, tree.inner_area_before());
    tree.give_back(bvh);
    EXPECT_TRUE(validate(bvh, mesh.size()).ok()) << validate(bvh, mesh.size()).message();
    EXPECT_LE(bvh.depth, levels);
    EXPECT_NEAR(area, inner_area_of(bvh), 1e-9 * area);
  }
}

// A chain is as deep as it may be; what moves must not make it deeper.
TEST(ReinsertionTree, ChainsGetNoDeeper) {
  const Bvh2 chain = test::chained(build<BinnedSah>(test::soup(150, 0.1f)).structure);
  Bvh2 bvh = copy_of(chain);
  ReinsertionTree tree(bvh, 10);
  for (const NodeRef subtree : all_refs(tree.node_count()))
    for (const NodeRef target : all_refs(tree.node_count())) tree.improve(subtree, target);
  tree.give_back(bvh);
  EXPECT_TRUE(validate(bvh, 150).ok()) << validate(bvh, 150).message();
  EXPECT_LE(bvh.depth, chain.depth);
}

TEST(ReinsertionSearch, FindsTheBestOfAllPlaces) {
  for (const Bvh2& bvh : {test::shuffled(build<BinnedSah>(test::soup(60, 0.4f), {.max_leaf_size = 2}).structure),
                          build<Sbvh>(test::slivers(30), {.reinsertion_rounds = 0}).structure,
                          test::shuffled(build<BinnedSah>(test::flat_grid(5), {.max_leaf_size = 1}).structure)}) {
    Bvh2 searched = copy_of(bvh);
    const ReinsertionTree tree(searched, kMaxBuildDepth);
    ReinsertionSearch search(tree);
    const std::vector<NodeRef> refs = all_refs(tree.node_count());
    int gains = 0;
    for (const NodeRef subtree : refs) {
      if (tree.slot_of(subtree) == ReinsertionTree::kRootSlot) continue;
      double best = 0, best_found = 0;
      const Reinsertion found = search.best_place(subtree);
      for (const NodeRef target : refs) {
        Bvh2 moved = copy_of(bvh);
        ReinsertionTree other(moved, kMaxBuildDepth);
        const double before = other.inner_area();
        if (!other.improve(subtree, target)) continue;
        best = std::max(best, before - other.inner_area());
        if (target == found.target) best_found = before - other.inner_area();
      }
      // The search is in single precision, so it may prefer one of two that are as good.
      const double tolerance = 1e-5 * half_area_in_double(bvh.bounds);
      EXPECT_NEAR(found.gain, best, tolerance);
      EXPECT_NEAR(best_found, best, tolerance);
      gains += best > tolerance ? 1 : 0;
    }
    EXPECT_GT(gains, 10);
  }
}

}  // namespace
}  // namespace accel
