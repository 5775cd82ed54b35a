#include "libaccel/structure/bvh8_stats.h"

#include <gtest/gtest.h>

#include "libaccel/build/wide_sbvh.h"
#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

// Two unit right triangles in the planes z = 0 and z = 1, each with the box [0, 1]^2 across.
TEST(Bvh8Stats, KnownTree) {
  const TriangleMesh mesh = test::mesh_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}});
  const Bvh8 bvh = WideSbvh::build(mesh, {.max_leaf_size = 1})->structure;
  const Bvh8Stats stats = bvh8_stats(bvh, 2, 3);
  // Half areas: root 1 + 1 + 1, each leaf 1.
  EXPECT_DOUBLE_EQ(stats.sah_cost, 2.0 + 3.0 * (1.0 / 3) + 3.0 * (1.0 / 3));
  EXPECT_EQ(stats.inner_nodes, 1u);
  EXPECT_EQ(stats.leaves, 2u);
  EXPECT_EQ(stats.depth, 1u);
  EXPECT_EQ(stats.triangles, 2u);
  EXPECT_EQ(stats.references, 2u);
  EXPECT_EQ(stats.leaves_by_depth, (std::vector<std::uint64_t>{0, 2}));
  EXPECT_EQ(stats.leaves_by_size, (std::vector<std::uint64_t>{0, 2}));
  EXPECT_EQ(stats.mean_children, 2.0);
  EXPECT_EQ(stats.mean_leaf_size, 1.0);
  EXPECT_EQ(stats.mean_block_size, 1.0);
  EXPECT_EQ(stats.leaf_size_variance, 0.0);
}

TEST(Bvh8Stats, EmptyTreeAndSingleLeaf) {
  EXPECT_EQ(bvh8_stats(Bvh8{}, 1, 1).sah_cost, 0.0);
  const Bvh8Stats stats = bvh8_stats(WideSbvh::build(test::soup(1, 1), {})->structure, 1, 1);
  EXPECT_EQ(stats.sah_cost, 1.0);
  EXPECT_EQ(stats.depth, 0u);
  EXPECT_EQ(stats.mean_children, 0.0);
}

}  // namespace
}  // namespace accel
