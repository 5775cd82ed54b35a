#include "libaccel/structure/two_level.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>

#include "libaccel/build/instances.h"
#include "libaccel/build/two_level_extras.h"
#include "libaccel/core/counter_rng.h"
#include "validation/stress/stress_instances.h"

namespace accel {
namespace {

InstancedMeshes placed_scene() { return validation::instanced_scenes()[7].scene; }

TwoLevelBvh built() {
  auto result = InstanceBuilder::build(placed_scene(), {});
  EXPECT_TRUE(result) << result.message();
  for (const Bvh2Extras extras : {Bvh2Extras::uncles, Bvh2Extras::full_hash}) {
    const Status added = add_extras(result->structure, extras, result->report);
    EXPECT_TRUE(added) << added.message();
  }
  return std::move(result->structure);
}

std::string complaint(const std::function<void(TwoLevelBvh&)>& corrupt) {
  TwoLevelBvh bvh = built();
  corrupt(bvh);
  const Status status = validate(bvh, placed_scene().size());
  return status ? "" : status.message();
}

TEST(ValidateTwoLevel, AcceptsWhatIsBuiltAndNothing) {
  EXPECT_EQ(complaint([](TwoLevelBvh&) {}), "");
  EXPECT_TRUE(validate(TwoLevelBvh{}, 0));
  EXPECT_FALSE(validate(TwoLevelBvh{}, 1));
  for (const auto& s : validation::instanced_scenes()) {
    const auto built_scene = InstanceBuilder::build(s.scene, {});
    ASSERT_TRUE(built_scene) << built_scene.message();
    const Status status = validate(built_scene->structure, s.scene.size());
    EXPECT_TRUE(status) << s.name << ": " << status.message();
  }
}

TEST(ValidateTwoLevel, Trees) {
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[1].first_node += 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[1].nodes = std::numeric_limits<std::uint64_t>::max(); }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[2].quads -= 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[2].first_quad = 0; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[1].root = kNoNode; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[1].depth += 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[1].triangles = 1; }), "") << "leaves name triangles that there are not";
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[0].triangles += 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.depth += 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.instance_depth += 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees.truncate(2); }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees = {}; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.nodes.truncate(b.nodes.size() - 1); }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.leaves.truncate(b.leaves.size() - 1); }), "");
}

TEST(ValidateTwoLevel, HashTables) {
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[2].first_displacement += 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[1].displacements *= 2; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[1].slots = std::numeric_limits<std::uint64_t>::max(); }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[2].first_slot = 0; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[2].hash_reciprocal += 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.trees[2].hash_multiplier ^= 1ull << 50; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.slots[b.slots.size() - 1] ^= 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.displacements.truncate(b.displacements.size() - 1); }), "");
}

TEST(ValidateTwoLevel, Instances) {
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.instances[3].tree = 0; }), "") << "a scene in itself";
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.instances[3].tree = 3; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.instances[0].tree = 3 - b.instances[0].tree; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.instances[5].first_prim += 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh& b) { b.instances.truncate(b.instances.size() - 1); }), "");
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  EXPECT_NE(complaint([&](TwoLevelBvh& b) { b.instances[2].to_object.linear[1][2] = nan; }), "");
  EXPECT_NE(complaint([&](TwoLevelBvh& b) { b.instances[2].to_object.origin.y = inf; }), "");
}

// Whatever validate() makes of random damage, it ends, and what it accepts names nothing outside of its arrays.
TEST(ValidateTwoLevel, SurvivesRandomDamage) {
  for (std::uint64_t i = 0; i < 300; ++i) {
    complaint([&](TwoLevelBvh& b) {
      CounterRng rng(3, i);
      TwoLevelBvh::for_each_array(b, [&](std::string_view, auto& array) {
        if (rng.next_below(2) == 0) return;
        auto* bytes = reinterpret_cast<unsigned char*>(array.data());
        bytes[rng.next_below(static_cast<std::uint32_t>(array.size_bytes()))] ^=
            static_cast<unsigned char>(1u << rng.next_below(8));
      });
    });
  }
}

TEST(TwoLevelBvh, MeshesAreStoredOnce) {
  const TwoLevelBvh bvh = built();
  EXPECT_EQ(bvh.trees.size(), 3u);
  EXPECT_EQ(bvh.instances.size(), 50u);
  EXPECT_EQ(bvh.trees[1].triangles, 40u);
  EXPECT_EQ(bvh.trees[2].triangles, 90u);
  EXPECT_EQ(bvh.trees[0].references, 50u);
}

}  // namespace
}  // namespace accel
