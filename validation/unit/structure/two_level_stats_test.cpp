#include "libaccel/structure/two_level_stats.h"

#include <gtest/gtest.h>

#include <numeric>

#include "libaccel/build/sbvh.h"
#include "libaccel/build/wide_sbvh.h"
#include "validation/stress/stress_instances.h"
#include "validation/stress/stress_scenes.h"
#include "validation/unit/build/built_instances.h"

namespace accel {
namespace {

using test::built;

Bvh2Stats stats_of(const Bvh2& tree) { return bvh2_stats(tree, 1, 1); }
Bvh8Stats stats_of(const Bvh8& tree) { return bvh8_stats(tree, 1, 1); }

// One instance in its place is its mesh, and costs what that costs.
template <class Builder, class Stats>
void expect_those_of_the_mesh(const TriangleMesh& mesh, const Stats& expected) {
  const auto stats = two_level_stats(built<Builder>(*InstancedMeshes::make({mesh}, {Instance{}})), 1, 2);
  EXPECT_DOUBLE_EQ(stats.sah_cost, expected.sah_cost);
  EXPECT_EQ(stats.instances.leaves, 1u);
  EXPECT_EQ(stats.meshes.inner_nodes, expected.inner_nodes);
  EXPECT_EQ(stats.meshes.leaves, expected.leaves);
  EXPECT_EQ(stats.meshes.references, expected.references);
  EXPECT_EQ(stats.meshes.leaves_by_size, expected.leaves_by_size);
  EXPECT_EQ(stats.meshes.leaves_by_depth, expected.leaves_by_depth);
  EXPECT_DOUBLE_EQ(stats.meshes.mean_leaf_size, expected.mean_leaf_size);
  EXPECT_DOUBLE_EQ(stats.meshes.leaf_size_variance, expected.leaf_size_variance);
}

TEST(TwoLevelStats, OfOneInstanceAreThoseOfItsMesh) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(300, 0.2f, 1));
  expect_those_of_the_mesh<InstanceBuilder>(mesh, bvh2_stats(Sbvh::build(mesh, {})->structure, 1, 2));
  expect_those_of_the_mesh<WideInstances>(mesh, bvh8_stats(WideSbvh::build(mesh, {})->structure, 1, 2));
}

template <class Builder>
class TwoLevelStatsOf : public testing::Test {};
using Builders = testing::Types<InstanceBuilder, WideInstances>;
TYPED_TEST_SUITE(TwoLevelStatsOf, Builders);

// Two unit squares of one triangle each far apart: the ray that meets the scene's box meets either rarely.
TYPED_TEST(TwoLevelStatsOf, CostsOfInstancesWeighTheirBoxes) {
  const TriangleMesh mesh = validation::mesh_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}});
  Affine moved{};
  for (int a = 0; a < 3; ++a) moved.m[a][a] = 1;
  moved.m[0][3] = 99;
  const auto bvh = built<TypeParam>(*InstancedMeshes::make({mesh}, {Instance{}, Instance{0, moved}}));
  const auto stats = two_level_stats(bvh, 1, 2);
  EXPECT_NEAR(stats.sah_cost, 1 + 2 * 2 * (1.0 / 100), 1e-3);
  EXPECT_EQ(stats.meshes.triangles, 1u) << "stored once";
}

TYPED_TEST(TwoLevelStatsOf, SumsAreOverTheLeavesOfAllMeshes) {
  for (const auto& s : validation::instanced_scenes()) {
    const auto bvh = built<TypeParam>(s.scene);
    const auto stats = two_level_stats(bvh, 1, 1);
    double size = 0, squared = 0;
    std::uint64_t leaves = 0;
    for (std::size_t i = 1; i < bvh.trees.size(); ++i) {
      const auto tree = stats_of(bvh.tree(i));
      const auto n = static_cast<double>(tree.leaves);
      leaves += tree.leaves, size += n * tree.mean_leaf_size;
      squared += n * (tree.leaf_size_variance + tree.mean_leaf_size * tree.mean_leaf_size);
    }
    EXPECT_EQ(stats.meshes.leaves, leaves) << s.name;
    EXPECT_EQ(std::accumulate(stats.meshes.leaves_by_size.begin(), stats.meshes.leaves_by_size.end(), std::uint64_t{0}),
              leaves);
    if (leaves == 0) continue;
    const double mean = size / static_cast<double>(leaves);
    EXPECT_NEAR(stats.meshes.mean_leaf_size, mean, 1e-9) << s.name;
    EXPECT_NEAR(stats.meshes.leaf_size_variance, squared / static_cast<double>(leaves) - mean * mean, 1e-9) << s.name;
  }
}

TEST(TwoLevelStats, OfNothing) {
  EXPECT_EQ(two_level_stats(TwoLevelBvh{}, 1, 1).sah_cost, 0.0);
  EXPECT_EQ(two_level_stats(TwoLevelBvh8{}, 1, 1).sah_cost, 0.0);
}

}  // namespace
}  // namespace accel
