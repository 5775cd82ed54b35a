#include "libaccel/structure/two_level_bvh8.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/trace/bvh8_instances_simd.h"
#include "validation/stress/stress_instances.h"
#include "validation/unit/build/built_instances.h"

namespace accel {
namespace {

using test::built;

InstancedMeshes scene() { return validation::instanced_scenes()[7].scene; }

std::string complaint(const std::function<void(TwoLevelBvh8&)>& corrupt, const BuildOptions& options = {}) {
  TwoLevelBvh8 bvh = built<WideInstances>(scene(), options);
  corrupt(bvh);
  const Status status = validate(bvh, scene().size());
  return status ? "" : status.message();
}

TEST(InstanceRef, IsNoOtherReference) {
  for (const std::uint32_t i : {0u, 1u, kMostInstances - 1}) {
    EXPECT_TRUE(is_instance(instance_ref(i)));
    EXPECT_EQ(instance_number(instance_ref(i)), i);
  }
  for (const NodeRef ref : {NodeRef{0}, kLeafBit - 1, block_ref(0, kMostCounted), block_ref(kMaxBlocks - 1, kMostCounted),
                            block_ref(0, kMostCounted + 1), instance_ref(kMostInstances), kNoNode})
    EXPECT_FALSE(is_instance(ref)) << ref;
}

TEST(ValidateTwoLevelBvh8, AcceptsWhatIsBuiltAndNothing) {
  EXPECT_EQ(complaint([](TwoLevelBvh8&) {}), "");
  EXPECT_EQ(complaint([](TwoLevelBvh8&) {}, {.max_depth = 0}), "");
  EXPECT_TRUE(validate(TwoLevelBvh8{}, 0));
  EXPECT_FALSE(validate(TwoLevelBvh8{}, 1));
  for (const auto& s : validation::instanced_scenes()) {
    const Status status = validate(built<WideInstances>(s.scene), s.scene.size());
    EXPECT_TRUE(status) << s.name << ": " << status.message();
  }
}

TEST(ValidateTwoLevelBvh8, Trees) {
  const auto most = std::numeric_limits<std::uint64_t>::max();
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.trees[1].first_node += 1; }), "");
  EXPECT_NE(complaint([=](TwoLevelBvh8& b) { b.trees[1].nodes = most; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.trees[2].blocks -= 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.trees[2].first_block = 0; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.trees[0].blocks = 1; }), "") << "instances have no blocks";
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.trees[1].root = kNoNode; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.trees[1].depth += 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.trees[1].triangles = 1; }), "") << "leaves name triangles that there are not";
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.trees[0].triangles += 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.depth += 1; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.root = b.trees[1].root; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.trees.truncate(2); }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.trees = {}; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.nodes.truncate(b.nodes.size() - 1); }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.blocks.truncate(b.blocks.size() - 1); }), "");
}

// References lead nowhere but to the nodes and blocks of their own tree, and only the tree over instances to these.
TEST(ValidateTwoLevelBvh8, References) {
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.nodes[0].child[0] = kInstanceBits | kMostInstances; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.nodes[0].child[0] = instance_ref(50); }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.nodes[0].child[0] = block_ref(0, 1); }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.nodes[0].child[0] = b.trees[1].root; }), "");
  const auto first_of = [](TwoLevelBvh8& b, int tree) -> Bvh8Node& { return b.nodes[b.trees[tree].first_node]; };
  EXPECT_NE(complaint([&](TwoLevelBvh8& b) { first_of(b, 1).child[0] = instance_ref(0); }), "");
  EXPECT_NE(complaint([&](TwoLevelBvh8& b) { first_of(b, 1).child[0] = 0; }), "");
  EXPECT_NE(complaint([&](TwoLevelBvh8& b) { first_of(b, 2).child[0] = block_ref(0, 1); }), "") << "a block of tree 1";
  EXPECT_NE(complaint([&](TwoLevelBvh8& b) { first_of(b, 2).child[0] = b.trees[1].root; }), "");
}

TEST(ValidateTwoLevelBvh8, Instances) {
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.instances[3].tree = 0; }), "") << "a scene in itself";
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.instances[3].tree = 3; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.instances[0].tree = 3 - b.instances[0].tree; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.instances[0].root = 0; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.instances[5].first_prim = 3250; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.instances[5].first_prim = kNoHit; }), "");
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.instances[5].ends_leaf = 0; }), "") << "a run of two leaves";
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.instances[49].ends_leaf = 0; }), "") << "a run without an end";
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.instances[20].ends_leaf = 1; }, {.max_depth = 0}), "") << "instances in no leaf";
  EXPECT_NE(complaint([](TwoLevelBvh8& b) { b.instances.truncate(b.instances.size() - 1); }), "");
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  EXPECT_NE(complaint([&](TwoLevelBvh8& b) { b.instances[2].to_object.linear[1][2] = nan; }), "");
  EXPECT_NE(complaint([&](TwoLevelBvh8& b) { b.instances[2].to_object.origin.y = inf; }), "");
}

// Whatever validate() makes of random damage, it ends, and what it accepts can be traced.
TEST(ValidateTwoLevelBvh8, SurvivesRandomDamage) {
  const std::vector<Ray> rays = validation::instance_rays(scene(), 20);
  std::size_t accepted = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    TwoLevelBvh8 bvh = built<WideInstances>(scene());
    CounterRng rng(3, i);
    TwoLevelBvh8::for_each_array(bvh, [&](std::string_view, auto& array) {
      if (rng.next_below(2) == 0) return;
      auto* bytes = reinterpret_cast<unsigned char*>(array.data());
      bytes[rng.next_below(static_cast<std::uint32_t>(array.size_bytes()))] ^=
          static_cast<unsigned char>(1u << rng.next_below(8));
    });
    if (!validate(bvh, scene().size())) continue;
    ++accepted;
    std::vector<Hit> hits(rays.size());
    Bvh8InstancesSimd<Watertight>::functions().trace(bvh.view(), rays.data(), rays.size(), hits.data());
    for (const Hit& hit : hits) EXPECT_TRUE(!hit.valid() || hit.prim_id < scene().size());
  }
  EXPECT_GT(accepted, 0u);
}

TEST(TwoLevelBvh8, MeshesAreStoredOnce) {
  const TwoLevelBvh8 bvh = built<WideInstances>(scene());
  EXPECT_EQ(bvh.trees.size(), 3u);
  EXPECT_EQ(bvh.instances.size(), 50u);
  EXPECT_EQ(bvh.trees[1].triangles, 40u);
  EXPECT_EQ(bvh.trees[2].triangles, 90u);
  EXPECT_EQ(bvh.trees[0].references, 50u);
}

}  // namespace
}  // namespace accel
