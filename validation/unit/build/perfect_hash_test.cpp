#include "libaccel/build/perfect_hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <unordered_set>
#include <vector>

#include <tbb/task_arena.h>

#include "libaccel/build/bvh2_hash.h"
#include "libaccel/build/bvh2_links.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/core/counter_rng.h"
#include "scenes/procedural.h"
#include "validation/stress/hash_trial.h"
#include "validation/stress/random_bvh2.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

NodeHashView view_of(const PerfectHash& hash, bool narrow) {
  NodeHashView view{hash.displacements.data(), hash.slots.data(), hash.multiplier};
  view.slot_count = static_cast<std::uint32_t>(hash.slots.size());
  view.log2_of_buckets = static_cast<std::uint32_t>(std::countr_zero(hash.displacements.size()));
  view.reciprocal = narrow ? reciprocal_of<std::uint32_t>(view.slot_count) : reciprocal_of<std::uint64_t>(view.slot_count);
  return view;
}

std::vector<HashedNode> random_keys(std::uint32_t count, int bits, std::uint64_t seed) {
  std::vector<HashedNode> nodes;
  std::unordered_set<std::uint64_t> seen;
  CounterRng rng(seed, 0);
  while (nodes.size() < count) {
    const std::uint64_t random = std::uint64_t{rng.next_below(0xffffffffu)} << 32 | rng.next_below(0xffffffffu);
    const std::uint64_t key = random >> (64 - bits);
    const auto ordinal = static_cast<std::uint32_t>(nodes.size());
    if (seen.insert(key).second) nodes.push_back({key, ordinal % 3 == 0 ? leaf_ref(ordinal) : ordinal});
  }
  return nodes;
}

PerfectHash hash_of(const std::vector<HashedNode>& nodes, bool narrow) {
  Result<PerfectHash> hash = make_perfect_hash([&](std::uint64_t) { return nodes; }, narrow);
  EXPECT_TRUE(hash);
  return hash ? std::move(*hash) : PerfectHash{};
}

void expect_found(const std::vector<HashedNode>& nodes, bool narrow) {
  const PerfectHash hash = hash_of(nodes, narrow);
  const NodeHashView view = view_of(hash, narrow);
  for (const HashedNode& node : nodes)
    ASSERT_EQ(narrow ? view.find(static_cast<std::uint32_t>(node.key)) : view.find(node.key), node.ref) << node.key;
}

TEST(PerfectHash, FindsAllKeysOfAllWidths) {
  for (const std::uint32_t count : {1u, 2u, 3u, 5u, 17u, 300u, 20000u}) {
    expect_found(random_keys(count, 32, count), true);
    expect_found(random_keys(count, 40, count), false);
    expect_found(random_keys(count, 64, count), false);
  }
}

// Wide keys that are equal modulo D and modulo H are met by chance all the time: the tables grow until they are not.
TEST(PerfectHash, GrowsPastKeysThatCannotBeSeparated) {
  std::uint32_t retries = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const PerfectHash hash = hash_of(random_keys(100, 64, seed), false);
    EXPECT_EQ(hash.slots.size() % 2, 1u);
    retries += hash.retries;
  }
  EXPECT_GT(retries, 20u) << "the test would say nothing";
}

TEST(PerfectHash, EqualKeysAreAnErrorThatEnds) {
  const auto twice = [](std::uint64_t) { return std::vector<HashedNode>{{7, 1}, {7, 2}, {9, 3}}; };
  for (const bool narrow : {false, true}) {
    const auto hash = make_perfect_hash(twice, narrow);
    ASSERT_FALSE(hash);
    EXPECT_NE(hash.message().find("max_depth"), std::string::npos) << hash.message();
  }
}

TEST(PerfectHash, ReferencesTooLargeForTheDisplacementTableGoIntoASlot) {
  const NodeRef large = leaf_ref(0x7ffffff0u);
  const std::vector<HashedNode> nodes{{5, large}};
  const PerfectHash hash = hash_of(nodes, true);
  EXPECT_EQ(hash.direct, 0u);
  EXPECT_EQ(view_of(hash, true).find(5u), large);
  EXPECT_EQ(direct_ref(direct_entry(leaf_ref(77))), leaf_ref(77));
  EXPECT_EQ(direct_ref(direct_entry(77)), 77u);
}

TEST(PerfectHash, TablesAreTheSameForAnyNumberOfThreads) {
  const std::vector<HashedNode> nodes = random_keys(60000, 45, 3);
  const PerfectHash one = tbb::task_arena(1).execute([&] { return hash_of(nodes, false); });
  for (const int threads : {2, 3}) {
    const PerfectHash other = tbb::task_arena(threads).execute([&] { return hash_of(nodes, false); });
    ASSERT_EQ(other.slots.size(), one.slots.size());
    EXPECT_EQ(std::memcmp(other.slots.data(), one.slots.data(), one.slots.size_bytes()), 0);
    EXPECT_EQ(std::memcmp(other.displacements.data(), one.displacements.data(), one.displacements.size_bytes()), 0);
  }
}

// A million in bench/hash_sweep.
TEST(PerfectHash, SucceedsOnRandomSkewedAndDegenerateTrees) {
  for (std::uint64_t number = 0; number < 2000; ++number) {
    const Status status = validation::try_hash(number).status;
    ASSERT_TRUE(status) << number << ": " << status.message();
  }
}

TEST(PerfectHash, NoTablesWhereNoKeyIsLookedUp) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(6, 0.3f, 1));
  Bvh2 tree = validation::random_bvh2(mesh, 1, {.shape = validation::TreeShape::balanced});
  BuildReport report;
  ASSERT_TRUE(add_hash(tree, HashedKeys::looked_up, report));
  EXPECT_TRUE(tree.displacements.empty());
  EXPECT_TRUE(tree.has(Bvh2Extras::hash));
  EXPECT_TRUE(std::any_of(report.notes.begin(), report.notes.end(),
                          [](const BuildNote& n) { return n.what == "hash tables" && n.why.find("skipped") == 0; }));
}

// [BK16] Table 1: at most 7 % more memory.
TEST(PerfectHash, TakesAtMostSevenPercentOfTheStructure) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const Result<SceneData> scene = make_builtin(std::string(builtin.name) + ":3000");
    ASSERT_TRUE(scene);
    const auto built = Sbvh::build(*scene->one_mesh(), {});
    ASSERT_TRUE(built);
    Bvh2 tree = built->structure;
    BuildReport report;
    ASSERT_TRUE(add_hash(tree, HashedKeys::looked_up, report));
    const double more = static_cast<double>(tree.size_bytes() - built->structure.size_bytes());
    EXPECT_LE(more, 0.07 * static_cast<double>(built->structure.size_bytes())) << builtin.name;
  }
}

}  // namespace
}  // namespace accel
