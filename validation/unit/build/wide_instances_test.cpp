#include "libaccel/build/wide_instances.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "libaccel/exec/drive.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/structure/two_level_stats.h"
#include "libaccel/trace/bvh8_instances.h"
#include "validation/compare/same_hit.h"
#include "validation/oracle/brute_instances.h"
#include "validation/stress/stress_instances.h"
#include "validation/unit/build/built_instances.h"

namespace accel {
namespace {

using test::built;
using Meshes = std::vector<TriangleMesh>;
using Instances = std::vector<Instance>;

InstancedMeshes with_instances(const InstancedMeshes& scene, Instances instances) {
  const auto placed = scene.with_instances(std::move(instances));
  EXPECT_TRUE(placed) << placed.message();
  return *placed;
}

Instances placed_again(const InstancedMeshes& scene, std::uint64_t seed) {
  Instances result(scene.instances().begin(), scene.instances().end());
  for (std::uint32_t i = 0; i < result.size(); ++i)
    result[i].transform =
        validation::placed_at({static_cast<float>(i % 5), 1, static_cast<float>(i / 5)}, {1, 2, 0.5f}, seed, i);
  return result;
}

TwoLevelBvh8 moved(const TwoLevelBvh8& bvh, const InstancedMeshes& scene, const BuildOptions& options = {}) {
  auto result = move_instances(bvh, scene, options);
  EXPECT_TRUE(result) << result.message();
  const Status valid = result ? validate(result->structure, scene.size()) : Status(Done{});
  EXPECT_TRUE(valid) << valid.message();
  return result ? result->structure : TwoLevelBvh8{};
}

void expect_hits_of_brute_force(const TwoLevelBvh8& bvh, const InstancedMeshes& scene) {
  std::size_t hits = 0;
  for (const Ray& ray : validation::instance_rays(scene, 200)) {
    NullObserver observer;
    const Hit hit = trace_ray<Bvh8Instances<Watertight, Query::closest>>(bvh.view(), ray, observer);
    EXPECT_TRUE(validation::same_hit(hit, validation::brute_force<Watertight>(scene, ray)));
    hits += hit.valid() ? 1 : 0;
  }
  EXPECT_TRUE(hits > 0 || scene.size() == 0);
}

// Each scene that hurts, from where its instances are placed otherwise.
TEST(MoveInstances, TracesWhatHasMoved) {
  for (const auto& s : validation::instanced_scenes()) {
    SCOPED_TRACE(s.name);
    const TwoLevelBvh8 elsewhere = built<WideInstances>(with_instances(s.scene, placed_again(s.scene, 7)));
    expect_hits_of_brute_force(moved(elsewhere, s.scene), s.scene);
  }
}

TEST(MoveInstances, InstancesComeAndGo) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  TwoLevelBvh8 bvh = built<WideInstances>(scene);
  const Instances all = placed_again(scene, 8);
  for (const std::size_t count : {50, 1, 3, 0, 9, 49}) {
    SCOPED_TRACE(count);
    const InstancedMeshes now = with_instances(scene, Instances(all.end() - count, all.end()));
    bvh = moved(bvh, now);
    EXPECT_EQ(bvh.instances.size(), count);
    expect_hits_of_brute_force(bvh, now);
  }
  Instances others = all;
  for (Instance& instance : others) instance.mesh = 1 - instance.mesh;
  const InstancedMeshes exchanged = with_instances(scene, others);
  expect_hits_of_brute_force(moved(bvh, exchanged), exchanged);
}

TEST(MoveInstances, TreesOverMeshesStay) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  const TwoLevelBvh8 bvh = built<WideInstances>(scene);
  const TwoLevelBvh8 now = moved(bvh, with_instances(scene, placed_again(scene, 9)));
  EXPECT_EQ(now.blocks.data(), bvh.blocks.data());
  for (std::size_t i = 1; i < 3; ++i) {
    const Bvh8 before = bvh.tree(i), after = now.tree(i);
    EXPECT_EQ(after.root, before.root);
    ASSERT_EQ(after.nodes.size(), before.nodes.size());
    EXPECT_EQ(std::memcmp(after.nodes.data(), before.nodes.data(), before.nodes.size_bytes()), 0);
  }
}

TEST(MoveInstances, TheSameBytesForAnyNumberOfThreadsAndKeepsToMaxDepth) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  const TwoLevelBvh8 bvh = built<WideInstances>(scene), one = moved(bvh, scene, {.threads = 1});
  for (const int threads : {2, 4}) {
    const TwoLevelBvh8 other = moved(bvh, scene, {.threads = threads});
    ASSERT_EQ(other.nodes.size(), one.nodes.size());
    EXPECT_EQ(std::memcmp(other.nodes.data(), one.nodes.data(), one.nodes.size_bytes()), 0);
    EXPECT_EQ(std::memcmp(other.instances.data(), one.instances.data(), one.instances.size_bytes()), 0);
  }
  for (const int depth : {0, 1, 2})
    EXPECT_LE(moved(bvh, scene, {.max_depth = depth}).trees[0].depth, static_cast<std::uint32_t>(depth));
}

// Of enough instances for tasks of their own, and another number of them than before.
TEST(MoveInstances, OfThousandsAreTheSameForAnyNumberOfThreads) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  Instances many;
  for (std::uint32_t i = 0; i < 5000; ++i)
    many.push_back(
        {i % 2, validation::placed_at({static_cast<float>(i % 70), 0, static_cast<float>(i / 70)}, {1, 1, 1}, 3, i)});
  const InstancedMeshes now = with_instances(scene, many);
  const TwoLevelBvh8 bvh = built<WideInstances>(scene), one = moved(bvh, now, {.threads = 1}),
                     four = moved(bvh, now, {.threads = 4});
  EXPECT_NE(one.trees[0].nodes, bvh.trees[0].nodes);
  ASSERT_EQ(four.nodes.size(), one.nodes.size());
  EXPECT_EQ(std::memcmp(four.nodes.data(), one.nodes.data(), one.nodes.size_bytes()), 0);
  EXPECT_EQ(std::memcmp(four.instances.data(), one.instances.data(), one.instances.size_bytes()), 0);
}

// What rays cost is nearly what they cost after a build.
TEST(MoveInstances, TheTreeIsAsGoodAsABuilds) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  const TwoLevelBvh8 fresh = built<WideInstances>(scene);
  const TwoLevelBvh8 now = moved(built<WideInstances>(with_instances(scene, placed_again(scene, 9))), scene);
  const double as_built = two_level_stats(fresh, 1, 1).sah_cost, after = two_level_stats(now, 1, 1).sah_cost;
  EXPECT_LT(after, 1.15 * as_built);
  EXPECT_GT(after, 0.85 * as_built);
}

// Files may have boxes that are infinite where they need not be.
TEST(MoveInstances, InfiniteBoxesKeepTheirInstances) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  TwoLevelBvh8 bvh = built<WideInstances>(scene);
  for (Bvh8Tree& tree : bvh.trees)
    if (&tree != bvh.trees.data()) tree.bounds.lo.y = -INFINITY, tree.bounds.hi.y = INFINITY;
  for (std::size_t n = bvh.trees[0].nodes; n < bvh.nodes.size(); ++n)
    for (std::uint32_t c = 0; c < kBvh8Arity && bvh.nodes[n].child[c] != kNoNode; ++c)
      bvh.nodes[n].planes[1][0][c] = -INFINITY, bvh.nodes[n].planes[1][1][c] = INFINITY;
  const Instances unturned = {{0, {}}, {1, {}}};  // whose maps multiply infinity by zero
  EXPECT_EQ(moved(bvh, with_instances(scene, unturned)).instances.size(), 2u);
}

TEST(MoveInstances, ReportsItself) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  const auto result = move_instances(built<WideInstances>(scene), scene, {});
  ASSERT_TRUE(result);
  EXPECT_GE(result->report.peak_bytes, result->structure.size_bytes());
  ASSERT_EQ(result->report.phases.size(), 3u);
  double seconds = 0;
  for (const BuildPhase& phase : result->report.phases) seconds += phase.seconds;
  EXPECT_NEAR(seconds, result->report.seconds, 1e-6);
}

TEST(MoveInstances, OtherMeshesAreRefused) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  const TwoLevelBvh8 bvh = built<WideInstances>(scene);
  const auto complaint = [&](Meshes meshes) {
    const auto made = InstancedMeshes::make(std::move(meshes), {});
    EXPECT_TRUE(made);
    return move_instances(bvh, *made, {}).message();
  };
  const TriangleMesh first = scene.meshes()[0], second = scene.meshes()[1];
  EXPECT_EQ(complaint({first}), "moving instances: the structure was built over 2 meshes, but the scene has 1; rebuild");
  EXPECT_EQ(complaint({first, second, first}),
            "moving instances: the structure was built over 2 meshes, but the scene has 3; rebuild");
  EXPECT_EQ(complaint({first, first}), "moving instances: mesh 2 had 90 triangles when it was built, but has 40; rebuild");
  EXPECT_FALSE(move_instances(bvh, scene, {.bins = 0}));
  EXPECT_FALSE(move_instances(bvh, scene, {.max_leaf_size = 0}));
  const auto stopped = move_instances(bvh, scene, {.progress = [](std::string_view, double) { return false; }});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.message(), "interrupted");
}

TEST(MoveInstances, OfNothing) {
  const InstancedMeshes nothing = *InstancedMeshes::make({}, {});
  EXPECT_EQ(moved(TwoLevelBvh8{}, nothing).instances.size(), 0u);
  EXPECT_EQ(moved(built<WideInstances>(nothing), nothing).root, kNoNode);
}

}  // namespace
}  // namespace accel
