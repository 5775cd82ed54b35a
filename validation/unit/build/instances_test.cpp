#include "libaccel/build/instances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <vector>

#include "libaccel/build/wide_sbvh.h"
#include "validation/stress/stress_instances.h"
#include "validation/stress/stress_scenes.h"
#include "validation/unit/build/built_instances.h"

namespace accel {
namespace {

using test::built;

// Of two boxes and of eight.
template <class Builder>
class InstanceBuilders : public testing::Test {};
using BuildersOfInstances = testing::Types<InstanceBuilder, WideInstances>;
TYPED_TEST_SUITE(InstanceBuilders, BuildersOfInstances);

TYPED_TEST(InstanceBuilders, TheSameBytesForAnyNumberOfThreads) {
  using Structure = typename TypeParam::Structure;
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  const Structure one = built<TypeParam>(scene, {.threads = 1});
  for (const int threads : {2, 4}) {
    const Structure other = built<TypeParam>(scene, {.threads = threads});
    std::vector<std::vector<std::byte>> bytes;
    for (const Structure* bvh : {&one, &other})
      Structure::for_each_array(*bvh, [&](std::string_view, const auto& array) {
        const auto* first = reinterpret_cast<const std::byte*>(array.data());
        bytes.emplace_back(first, first + array.size_bytes());
      });
    for (std::size_t i = 0; i < bytes.size() / 2; ++i) EXPECT_TRUE(bytes[i] == bytes[i + bytes.size() / 2]) << i;
  }
}

// The stand-in of an instance, as the tree over instances has it.
Aabb box_of(const TwoLevelBvh& bvh, std::uint32_t instance) {
  const Bvh2 top = bvh.tree(0);
  for (std::uint32_t quad = 0; quad < top.leaves.size(); quad += is_end_of_leaf(top.leaves.data(), quad) ? 1 : 3)
    if (!is_end_of_leaf(top.leaves.data(), quad) && top.leaves[quad].word == instance)
      return packed_triangle(top.leaves.data(), quad).vertices().bounds();
  return {};
}

TEST(InstanceBuilder, BoxesContainTheirInstances) {
  for (const auto& s : validation::instanced_scenes()) {
    const TwoLevelBvh bvh = built(s.scene);
    for (std::uint32_t i = 0; i < s.scene.instances().size(); ++i) {
      const Instance& instance = s.scene.instances()[i];
      const Aabb box = box_of(bvh, i);
      EXPECT_EQ(box.empty(), s.scene.meshes()[instance.mesh].size() == 0) << s.name << ", instance " << i;
      for (const Vec3& v : s.scene.meshes()[instance.mesh].vertices) {
        const Vec3d p = transform_point(instance.transform, Vec3d(v));
        EXPECT_TRUE(box.lo.x < p.x && p.x < box.hi.x && box.lo.y < p.y && p.y < box.hi.y && box.lo.z < p.z && p.z < box.hi.z)
            << s.name << ", instance " << i;
      }
    }
  }
}

TEST(InstanceBuilder, OneInstanceALeaf) {
  const TwoLevelBvh bvh = built(validation::instanced_scenes()[7].scene);
  EXPECT_EQ(bvh.trees[0].nodes, 49u);
}

TYPED_TEST(InstanceBuilders, KeepToMaxDepth) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  for (const int depth : {0, 1, 3}) {
    const auto bvh = built<TypeParam>(scene, {.max_depth = depth});
    EXPECT_LE(bvh.depth, static_cast<std::uint32_t>(depth));
    const Status valid = validate(bvh, scene.size());
    EXPECT_TRUE(valid) << valid.message();
  }
}

TYPED_TEST(InstanceBuilders, ReportWhatIsStored) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  const auto result = TypeParam::build(scene, {});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.triangles, 130u);
  EXPECT_GE(result->report.references, 130u);
  EXPECT_GE(result->report.peak_bytes, result->structure.size_bytes());
  ASSERT_EQ(result->report.notes.size(), 1u);
  EXPECT_EQ(result->report.notes[0].why, "50 of 2 meshes: 130 triangles are stored, for 3250 in the scene");
}

// A scene of many small meshes is one build, not as many.
TYPED_TEST(InstanceBuilders, TellsItsProgressOfAllMeshes) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(20, 0.5f, 1));
  std::vector<Instance> instances(300);
  for (std::uint32_t i = 0; i < 300; ++i) instances[i].mesh = i;
  const InstancedMeshes scene = *InstancedMeshes::make(std::vector<TriangleMesh>(300, mesh), instances);
  std::vector<double> told;
  BuildOptions options;
  options.progress = [&](std::string_view phase, double fraction) {
    if (phase == "meshes") told.push_back(fraction);
    return true;
  };
  const auto start = std::chrono::steady_clock::now();
  ASSERT_TRUE(TypeParam::build(scene, options));
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  ASSERT_FALSE(told.empty());
  EXPECT_LE(static_cast<double>(told.size()), 1 + 10 * taken.count()) << "ten times a second";
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_LE(told.back(), 1);
}

TYPED_TEST(InstanceBuilders, BadOptionsAndInterruptionsAreErrors) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  EXPECT_FALSE(TypeParam::build(scene, {.bins = 0}));
  const auto stopped = TypeParam::build(scene, {.progress = [](std::string_view, double) { return false; }});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.message(), "interrupted");
}

// Trees over meshes are those of WideSbvh; each instance that rays can hit has one place, alone in its leaf.
TEST(WideInstances, KeepsTreesAndInstances) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  const TwoLevelBvh8 bvh = built<WideInstances>(scene);
  ASSERT_EQ(bvh.trees.size(), 3u);
  for (std::size_t mesh = 0; mesh < 2; ++mesh) {
    const auto alone = WideSbvh::build(scene.meshes()[mesh], {});
    ASSERT_TRUE(alone) << alone.message();
    const Bvh8 tree = bvh.tree(mesh + 1);
    EXPECT_EQ(tree.root, alone->structure.root);
    ASSERT_EQ(tree.nodes.size(), alone->structure.nodes.size());
    ASSERT_EQ(tree.blocks.size(), alone->structure.blocks.size());
    EXPECT_EQ(std::memcmp(tree.nodes.data(), alone->structure.nodes.data(), tree.nodes.size_bytes()), 0);
    EXPECT_EQ(std::memcmp(tree.blocks.data(), alone->structure.blocks.data(), tree.blocks.size_bytes()), 0);
  }
  std::vector<std::uint32_t> first_prims;
  for (const Bvh8Instance& instance : bvh.instances) {
    EXPECT_EQ(instance.ends_leaf, 1u);
    first_prims.push_back(instance.first_prim);
  }
  std::sort(first_prims.begin(), first_prims.end());
  ASSERT_EQ(first_prims.size(), scene.instances().size());
  for (std::size_t i = 0; i < first_prims.size(); ++i) EXPECT_EQ(first_prims[i], scene.first_prim(i));
}

// Where the tree over instances may have no node, its leaf is all of them.
TEST(WideInstances, LeavesOfManyInstancesAreRuns) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  const TwoLevelBvh8 bvh = built<WideInstances>(scene, {.max_depth = 0});
  EXPECT_TRUE(is_instance(bvh.root));
  ASSERT_EQ(bvh.instances.size(), 50u);
  for (std::size_t i = 0; i < 50; ++i) EXPECT_EQ(bvh.instances[i].ends_leaf, i == 49 ? 1u : 0u);
}

}  // namespace
}  // namespace accel
