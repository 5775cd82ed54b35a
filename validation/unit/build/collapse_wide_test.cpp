#include "libaccel/build/collapse_wide.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "libaccel/build/binned_sah.h"
#include "libaccel/structure/bvh2_walk.h"
#include "libaccel/structure/bvh8_stats.h"
#include "validation/stress/random_bvh2.h"
#include "validation/unit/build/builder_checks.h"

namespace accel {
namespace {

// The least cost of any collapse, by trying all of them: what cost(n, i) means, from the root down, in double.
class EveryCollapse {
 public:
  EveryCollapse(const Bvh2& bvh, const BuildOptions& options) : bvh_(bvh), options_(options) {}

  double least() { return forest(bvh_.root, bvh_.bounds, 1) / half_area_in_double(bvh_.bounds); }

 private:
  double forest(NodeRef ref, const Aabb& box, int roots) {
    const auto key = std::make_pair(ref, roots);
    if (const auto known = known_.find(key); known != known_.end()) return known->second;
    double cost = leaf(ref, box);
    if (!is_leaf(ref)) {
      if (roots == 1) cost = std::min(cost, half_area_in_double(box) * options_.traversal_cost + split(ref, 8));
      for (int r = 2; r <= roots; ++r) cost = std::min(cost, split(ref, r));
      if (roots > 1) cost = std::min(cost, forest(ref, box, 1));
    }
    return known_[key] = cost;
  }

  double split(NodeRef ref, int roots) {
    const Bvh2Node& node = bvh_.nodes[ref];
    double cost = std::numeric_limits<double>::infinity();
    for (int left = 1; left < roots; ++left)
      cost = std::min(cost, forest(node.child[0], node.bounds(0), left) + forest(node.child[1], node.bounds(1), roots - left));
    return cost;
  }

  double leaf(NodeRef ref, const Aabb& box) const {
    std::uint32_t triangles = 0;
    walk_bvh2(bvh_.view(), {ref}, 0, [&](const Bvh2Place& place) {
      if (is_leaf(place.ref)) triangles += (terminator_of(bvh_.leaves.data(), place.ref) - leaf_quad(place.ref)) / 3;
      return true;
    });
    if (!is_leaf(ref) && triangles > static_cast<std::uint32_t>(options_.max_leaf_size))
      return std::numeric_limits<double>::infinity();
    return half_area_in_double(box) * options_.intersection_cost * ((triangles + kBlockLanes - 1) / kBlockLanes);
  }

  const Bvh2& bvh_;
  const BuildOptions& options_;
  std::map<std::pair<NodeRef, int>, double> known_;
};

TEST(CollapseWide, NoCollapseIsCheaper) {
  for (const float intersection_cost : {0.0f, 0.3f, 1.0f, 5.0f})
    for (const int leaf_size : {1, 3, 8, 40}) {
      BuildOptions options;
      options.intersection_cost = intersection_cost, options.max_leaf_size = leaf_size;
      for (const TriangleMesh& mesh : {test::soup(500, 0.1f), test::doubling(100), test::flat_grid(12)}) {
        const Bvh2 binary = test::build<BinnedSah>(mesh, {.max_leaf_size = 2}).structure;
        const Bvh8 wide = *collapse_wide(binary, options);
        const double least = EveryCollapse(binary, options).least();
        EXPECT_NEAR(bvh8_stats(wide, options.traversal_cost, intersection_cost).sah_cost, least, 1e-5 * least);
      }
    }
}

// prim_ids of a leaf, each once.
std::set<std::uint32_t> triangles_of(const Bvh8& bvh, NodeRef leaf) {
  std::set<std::uint32_t> found;
  for (std::uint32_t b = first_block(leaf); b < first_block(leaf) + block_count(bvh.blocks, leaf); ++b)
    for (std::uint32_t lane = 0; lane < kBlockLanes && bvh.blocks[b].has(lane); ++lane)
      EXPECT_TRUE(found.insert(bvh.blocks[b].prim_id[lane]).second) << "twice in a leaf";
  return found;
}

// Trees of all shapes, deep ones too, and none loses a triangle.
TEST(CollapseWide, TreesOfAllShapes) {
  const TriangleMesh mesh = test::soup(1500, 0.1f);
  for (const validation::TreeShape shape : validation::kTreeShapes)
    for (const std::uint32_t leaf_size : {1u, 6u, 100u}) {
      const Bvh2 binary = validation::random_bvh2(mesh, 5, {.shape = shape, .leaf_size = leaf_size});
      const Result<Bvh8> wide = collapse_wide(binary, {});
      ASSERT_TRUE(wide) << wide.message();
      const Status valid = validate(*wide, mesh.size());
      EXPECT_TRUE(valid) << valid.message();
      EXPECT_LE(wide->depth, binary.depth);
      EXPECT_EQ(bvh8_stats(*wide, 1, 1).triangles, 1500u);
    }
}

// Leaves of more blocks than a reference counts.
TEST(CollapseWide, LongLeavesEndInAnEmptyBlock) {
  for (const std::uint32_t triangles : {23u, 24u, 25u, 28u, 29u, 500u}) {
    const Bvh2 binary = test::build<BinnedSah>(test::identical(triangles), {.max_depth = 0}).structure;
    ASSERT_TRUE(is_leaf(binary.root));
    const Bvh8 wide = *collapse_wide(binary, {});
    ASSERT_TRUE(is_leaf(wide.root));
    const Status valid = validate(wide, triangles);
    EXPECT_TRUE(valid) << valid.message();
    EXPECT_EQ(counted_blocks(wide.root), triangles <= 4 * kMostCounted ? 6u : 0u);
    EXPECT_EQ(triangles_of(wide, wide.root).size(), triangles);
  }
}

// Along an octant's diagonal, the children that there are come from the farthest to the nearest.
TEST(CollapseWide, ChildrenAreInOrder) {
  const Bvh8 wide = *collapse_wide(test::build<BinnedSah>(test::soup(2000, 0.05f)).structure, {});
  for (const Bvh8Node& node : wide.nodes)
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      float last = std::numeric_limits<float>::infinity();
      for (std::uint32_t i = 0; i < kBvh8Arity; ++i) {
        const std::uint32_t c = node.ordered(i, octant);
        if (node.child[c] == kNoNode) continue;
        const Vec3 centre = node.bounds(c).center();
        float along = 0;
        for (int a = 0; a < 3; ++a) along += (octant >> a & 1u) != 0 ? -centre[a] : centre[a];
        EXPECT_LE(along, last);
        last = along;
      }
    }
}

TEST(CollapseWide, NothingStaysNothing) {
  const Result<Bvh8> wide = collapse_wide(Bvh2{}, {});
  ASSERT_TRUE(wide);
  EXPECT_EQ(wide->root, kNoNode);
  EXPECT_EQ(wide->size_bytes(), 0u);
}

}  // namespace
}  // namespace accel
