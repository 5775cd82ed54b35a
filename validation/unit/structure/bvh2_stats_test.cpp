#include "libaccel/structure/bvh2_stats.h"

#include <gtest/gtest.h>

#include "libaccel/build/binned_sah.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/geometry/clip_triangle.h"
#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

// Two unit right triangles in the planes z = 0 and z = 1, each with the box [0, 1]^2 across.
Bvh2 two_leaves(float lo_of_second) {
  const TriangleMesh mesh = test::mesh_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}});
  BuildOptions options;
  options.max_leaf_size = 1;
  Bvh2 bvh = std::move(BinnedSah::build(mesh, options)->structure);
  const int second = bvh.leaves[leaf_quad(bvh.nodes[0].child[0])].word == 1 ? 0 : 1;
  bvh.nodes[0].set_bounds(second, {{0, 0, lo_of_second}, {1, 1, 1}});
  return bvh;
}

TEST(Bvh2Stats, KnownTree) {
  const Bvh2Stats stats = bvh2_stats(two_leaves(1), 2, 3);
  // Half areas: root 1 + 1 + 1, each leaf 1.
  EXPECT_DOUBLE_EQ(stats.sah_cost, 2.0 + 3.0 * (1.0 / 3) + 3.0 * (1.0 / 3));
  EXPECT_EQ(stats.inner_nodes, 1u);
  EXPECT_EQ(stats.leaves, 2u);
  EXPECT_EQ(stats.depth, 1u);
  EXPECT_EQ(stats.leaves_by_depth, (std::vector<std::uint64_t>{0, 2}));
  EXPECT_EQ(stats.leaves_by_size, (std::vector<std::uint64_t>{0, 2}));
  EXPECT_EQ(stats.mean_leaf_size, 1.0);
  EXPECT_EQ(stats.leaf_size_variance, 0.0);
  EXPECT_EQ(stats.duplication(), 0.0);
}

TEST(EndPointOverlap, KnownTree) {
  EXPECT_EQ(end_point_overlap(two_leaves(1), 2, 3), 0.0);
  EXPECT_EQ(end_point_overlap(two_leaves(0.5f), 2, 3), 0.0);
  // The second leaf's box now holds the whole first triangle, half of the surface.
  EXPECT_DOUBLE_EQ(end_point_overlap(two_leaves(0), 2, 3), 3.0 * 0.5);
}

TEST(EndPointOverlap, EmptyTreeAndSingleLeaf) {
  EXPECT_EQ(end_point_overlap({}, 1, 1), 0.0);
  EXPECT_EQ(end_point_overlap(BinnedSah::build(test::soup(1, 1), {})->structure, 1, 1), 0.0);
  EXPECT_EQ(bvh2_stats({}, 1, 1).sah_cost, 0.0);
}

// The definition, node by node and without pruning.
double overlap_by_definition(const Bvh2& bvh, const TriangleMesh& mesh, NodeRef ref, const Aabb& box, bool is_root,
                             std::vector<bool>& members) {
  members.assign(mesh.size(), false);
  double sum = 0, cost = 1;
  if (is_leaf(ref)) {
    cost = 0;
    for (std::uint32_t q = leaf_quad(ref); !is_end_of_leaf(bvh.leaves.data(), q); q += kQuadsPerTriangle)
      members[bvh.leaves[q].word] = true, cost += 1;
  } else {
    std::vector<bool> below;
    for (int c = 0; c < 2; ++c) {
      sum += overlap_by_definition(bvh, mesh, bvh.nodes[ref].child[c], bvh.nodes[ref].bounds(c), false, below);
      for (std::size_t i = 0; i < below.size(); ++i) members[i] = members[i] || below[i];
    }
  }
  for (std::size_t i = 0; i < mesh.size() && !is_root; ++i) {
    ClippedPolygon polygon(mesh.triangle(i));
    polygon.clip(box);
    if (!members[i]) sum += cost * polygon.area();
  }
  return sum;
}

TEST(EndPointOverlap, AgreesWithItsDefinition) {
  const TriangleMesh mesh = test::soup(120, 0.7f);
  double surface = 0;
  for (std::size_t i = 0; i < mesh.size(); ++i) surface += ClippedPolygon(mesh.triangle(i)).area();
  for (const Bvh2& bvh : {BinnedSah::build(mesh, {})->structure, Sbvh::build(mesh, {})->structure}) {
    std::vector<bool> members;
    const double expected = overlap_by_definition(bvh, mesh, bvh.root, bvh.bounds, true, members) / surface;
    EXPECT_NEAR(end_point_overlap(bvh, 1, 1), expected, 1e-9 * expected);
    EXPECT_NEAR(end_point_overlap(bvh, 1, 1, 2), expected, 0.5 * expected);
  }
}

TEST(Bvh2Stats, SpatialSplitsShowAsDuplication) {
  const Bvh2 bvh = Sbvh::build(test::slivers(500), {})->structure;
  const Bvh2Stats stats = bvh2_stats(bvh, 1, 1);
  EXPECT_EQ(stats.triangles, 500u);
  EXPECT_GT(stats.duplication(), 0.1);
  EXPECT_LE(stats.duplication(), 0.5);
}

}  // namespace
}  // namespace accel
