#include "libaccel/build/instances.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/build/sbvh.h"
#include "validation/stress/stress_instances.h"
#include "validation/unit/build/built_instances.h"

namespace accel {
namespace {

using test::built;

TEST(InstanceBuilder, TheSameBytesForAnyNumberOfThreads) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  const TwoLevelBvh one = built(scene, {.threads = 1});
  for (const int threads : {2, 4}) {
    const TwoLevelBvh other = built(scene, {.threads = threads});
    std::vector<std::vector<std::byte>> bytes;
    for (const TwoLevelBvh* bvh : {&one, &other})
      TwoLevelBvh::for_each_array(*bvh, [&](std::string_view, const auto& array) {
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

TEST(InstanceBuilder, KeepsToMaxDepth) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  for (const int depth : {0, 1, 3}) {
    const TwoLevelBvh bvh = built(scene, {.max_depth = depth});
    EXPECT_LE(bvh.depth, static_cast<std::uint32_t>(depth));
    EXPECT_TRUE(validate(bvh, scene.size()));
  }
}

TEST(InstanceBuilder, ReportsWhatIsStored) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  const auto result = InstanceBuilder::build(scene, {});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.triangles, 130u);
  EXPECT_GE(result->report.peak_bytes, result->structure.size_bytes());
  ASSERT_EQ(result->report.notes.size(), 1u);
  EXPECT_EQ(result->report.notes[0].why, "50 of 2 meshes: 130 triangles are stored, for 3250 in the scene");
}

TEST(InstanceBuilder, BadOptionsAndInterruptionsAreErrors) {
  const InstancedMeshes scene = validation::instanced_scenes()[7].scene;
  EXPECT_FALSE(InstanceBuilder::build(scene, {.bins = 0}));
  const auto stopped = InstanceBuilder::build(scene, {.progress = [](std::string_view, double) { return false; }});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.message(), "interrupted");
}

}  // namespace
}  // namespace accel
