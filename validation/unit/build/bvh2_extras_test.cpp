// The annotations of two-box BVHs: what they say, that they exclude each other where they must, and that validate() proves
// every word of them.
#include "libaccel/build/bvh2_extras.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <tbb/task_arena.h>

#include "libaccel/structure/bvh2_walk.h"
#include "validation/stress/random_bvh2.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

constexpr std::uint32_t kTriangles = 300;

Bvh2 tree_with(std::initializer_list<Bvh2Extras> all, validation::TreeShape shape = validation::TreeShape::random) {
  Bvh2 tree =
      validation::random_bvh2(validation::mesh_of(validation::random_triangles(kTriangles, 0.3f, 1)), 5, {.shape = shape});
  BuildReport report;
  for (const Bvh2Extras extras : all) {
    EXPECT_TRUE(add_extras(tree, extras, report));
    EXPECT_TRUE(tree.has(extras));
  }
  return tree;
}

std::string complaint(const Bvh2& tree) {
  const Status status = validate(tree, kTriangles);
  return status ? "" : status.message();
}

template <class T>
Buffer<T> own(const Buffer<T>& shared) {
  return Buffer<T>::copy_of(shared.span());
}

TEST(Bvh2Extras, OfAllKindsAreValid) {
  for (const validation::TreeShape shape : validation::kTreeShapes)
    for (const Bvh2Extras extras : Bvh2::kExtras)
      EXPECT_EQ(complaint(tree_with({extras}, shape)), "") << Bvh2::extras_name(extras);
  EXPECT_EQ(complaint(tree_with(
                {Bvh2Extras::uncles, Bvh2Extras::full_hash, Bvh2Extras::skips, Bvh2Extras::octant_skips, Bvh2Extras::octo})),
            "");
}

// There is room for one kind of links; those who share the arrays keep what they have.
TEST(Bvh2Extras, LinksReplaceEachOtherInCopies) {
  const Bvh2 plain = tree_with({});
  Bvh2 tree = plain;
  add_links(tree, Bvh2Links::uncles);
  const Bvh2 uncles = tree;
  add_links(tree, Bvh2Links::parents);
  EXPECT_TRUE(tree.has(Bvh2Extras::parents));
  EXPECT_FALSE(tree.has(Bvh2Extras::uncles));
  for (const Bvh2* t : {&plain, &uncles, static_cast<const Bvh2*>(&tree)}) EXPECT_EQ(complaint(*t), "");
  add_links(tree, Bvh2Links::none);
  EXPECT_EQ(std::memcmp(tree.nodes.data(), plain.nodes.data(), plain.nodes.size_bytes()), 0);
  EXPECT_EQ(std::memcmp(tree.leaves.data(), plain.leaves.data(), plain.leaves.size_bytes()), 0);
}

TEST(Bvh2Extras, RelativesOfAPath) {
  const Bvh2 tree = tree_with({Bvh2Extras::uncles});
  const Bvh2View view = tree.view();
  const Bvh2Place root{.ref = tree.root};
  const Bvh2Place child = root.child(view, 1, 0), grandchild = child.child(view, 0, 0);
  EXPECT_EQ(child.sibling, tree.nodes[tree.root].child[0]);
  EXPECT_EQ(child.uncle, kNoNode);
  EXPECT_EQ(grandchild.uncle, child.sibling);
  EXPECT_EQ(grandchild.grand_uncle, kNoNode);
  EXPECT_EQ(grandchild.parent, child.ref);
  EXPECT_EQ(grandchild.key.window, 6u);
}

TEST(Bvh2Extras, ASingleLeafAndAnEmptyTree) {
  const TriangleMesh one = validation::mesh_of(validation::random_triangles(1, 0.3f, 1));
  for (Bvh2 tree : {validation::random_bvh2(one, 1), Bvh2{}})
    for (const Bvh2Extras extras : Bvh2::kExtras) {
      BuildReport report;
      EXPECT_TRUE(add_extras(tree, extras, report));
      EXPECT_TRUE(tree.has(extras));
      EXPECT_EQ(complaint(tree), "");
    }
}

TEST(Bvh2Extras, AreTheSameForAnyNumberOfThreads) {
  const auto annotated = [](int threads) {
    return tbb::task_arena(threads).execute([] {
      return tree_with({Bvh2Extras::uncles, Bvh2Extras::full_hash, Bvh2Extras::octant_skips});
    });
  };
  const Bvh2 one = annotated(1), three = annotated(3);
  const auto same = [](const auto& a, const auto& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
  };
  EXPECT_TRUE(same(one.nodes, three.nodes) && same(one.leaves, three.leaves) && same(one.slots, three.slots) &&
              same(one.displacements, three.displacements) && same(one.octant_skips, three.octant_skips));
}

// Every word that a traverser follows is proved.
TEST(ValidateBvh2Extras, LinksOfNodesAndLeaves) {
  for (const Bvh2Extras kind : {Bvh2Extras::parents, Bvh2Extras::uncles}) {
    const Bvh2 good = tree_with({kind});
    const auto damaged = [&](const std::function<void(Bvh2&)>& damage) {
      Bvh2 tree = good;
      tree.nodes = own(tree.nodes), tree.leaves = own(tree.leaves);
      damage(tree);
      return complaint(tree);
    };
    for (std::size_t i = 0; i < good.nodes.size(); i += 7)
      for (const int l : {0, 1}) EXPECT_NE(damaged([&](Bvh2& t) { t.nodes[i].link[l] ^= 1; }), "");
    const std::uint32_t end = terminator_of(good.leaves.data(), leaf_ref(0));
    for (const int l : {0, 1, 2}) EXPECT_NE(damaged([&](Bvh2& t) { t.leaves[end].link[l] ^= 4; }), "");
    for (const int q : {1, 2}) EXPECT_NE(damaged([&](Bvh2& t) { t.leaves[q].word ^= 4; }), "");
    EXPECT_NE(damaged([&](Bvh2& t) { t.links = Bvh2Links::none; }), "");
    EXPECT_NE(damaged([&](Bvh2& t) { t.links = static_cast<Bvh2Links>(3); }), "");
  }
}

TEST(ValidateBvh2Extras, HashTables) {
  const Bvh2 good = tree_with({Bvh2Extras::full_hash});
  const auto damaged = [&](const std::function<void(Bvh2&)>& damage) {
    Bvh2 tree = good;
    tree.displacements = own(tree.displacements), tree.slots = own(tree.slots);
    damage(tree);
    return complaint(tree);
  };
  EXPECT_EQ(damaged([](Bvh2&) {}), "");
  for (std::size_t i = 0; i < good.slots.size(); ++i) {
    EXPECT_NE(damaged([&](Bvh2& t) { t.slots[i] ^= 1; }), "");
    EXPECT_NE(damaged([&](Bvh2& t) { t.slots[i] = t.slots[i] == kNoNode ? 0 : kNoNode; }), "");
  }
  EXPECT_NE(damaged([](Bvh2& t) { t.slots = {}; }), "");
  EXPECT_NE(damaged([](Bvh2& t) { t.slots.truncate(t.slots.size() - 1); }), "");
  EXPECT_NE(damaged([](Bvh2& t) { t.displacements.truncate(t.displacements.size() - 1); }), "");
  EXPECT_NE(damaged([](Bvh2& t) { t.displacements.truncate(1); }), "");
  EXPECT_NE(damaged([](Bvh2& t) { t.hash_multiplier ^= 1ull << 50; }), "");
  EXPECT_NE(damaged([](Bvh2& t) { t.hashed = HashedKeys::looked_up; }), "") << "others are stored";
  EXPECT_NE(damaged([](Bvh2& t) { t.hashed = HashedKeys::none; }), "");
  EXPECT_NE(damaged([](Bvh2& t) { t.hashed = static_cast<HashedKeys>(7); }), "");
}

TEST(ValidateBvh2Extras, SkipPointers) {
  const Bvh2 good = tree_with({Bvh2Extras::skips, Bvh2Extras::octant_skips});
  const auto damaged = [&](const std::function<void(Bvh2&)>& damage) {
    Bvh2 tree = good;
    tree.skips = own(tree.skips), tree.octant_skips = own(tree.octant_skips);
    damage(tree);
    return complaint(tree);
  };
  for (std::size_t i = 0; i < good.skips.size(); ++i) EXPECT_NE(damaged([&](Bvh2& t) { t.skips[i] ^= 1; }), "");
  for (std::size_t i = 0; i < good.octant_skips.size(); i += 13)
    EXPECT_NE(damaged([&](Bvh2& t) { t.octant_skips[i] ^= 2; }), "");
  EXPECT_NE(damaged([](Bvh2& t) { t.octant_skips.truncate(t.octant_skips.size() / 2); }), "");
}

TEST(Bvh2Extras, OctoNodesAreFullAndOrderedInSpace) {
  const Bvh2 tree = tree_with({Bvh2Extras::octo}, validation::TreeShape::balanced);
  ASSERT_GT(tree.octo.size(), 4u);
  EXPECT_EQ(std::popcount(tree.octo[0].child_mask), 8);
  EXPECT_LT(tree.octo.size(), tree.nodes.size() / 2);
  // Of two children whose places differ in one axis only, the one in the lower place has the lower centre, mostly.
  int right = 0, wrong = 0;
  for (const OctoNode& node : tree.octo)
    for (std::uint32_t c = 0; c < kOctoArity; ++c)
      for (int a = 0; a < 3; ++a) {
        const std::uint32_t other = c | 1u << a;
        if (other == c || node.child[c] == kNoNode || node.child[other] == kNoNode) continue;
        const bool ascends = node.lower[a][c] + node.upper[a][c] <= node.lower[a][other] + node.upper[a][other];
        ++(ascends ? right : wrong);
      }
  EXPECT_GT(right, 4 * wrong);
}

TEST(Bvh2Extras, OctoNodesDoNotDependOnTheNumberOfThreads) {
  const auto mesh = validation::mesh_of(validation::random_triangles(40000, 0.01f, 2));
  const Bvh2 tree = validation::random_bvh2(mesh, 3, {.shape = validation::TreeShape::balanced});
  const auto octo_of = [&](int threads) {
    return tbb::task_arena(threads).execute([&] {
      Bvh2 copy = tree;
      EXPECT_TRUE(add_octo(copy));
      return copy.octo;
    });
  };
  const Buffer<OctoNode> one = octo_of(1), three = octo_of(3);
  ASSERT_EQ(one.size(), three.size());
  EXPECT_EQ(std::memcmp(one.data(), three.data(), one.size_bytes()), 0);
}

TEST(ValidateBvh2Extras, OctoNodes) {
  const Bvh2 good = tree_with({Bvh2Extras::octo});
  ASSERT_GT(good.octo.size(), 3u);
  const auto damaged = [&](const std::function<void(Bvh2&)>& damage) {
    Bvh2 tree = good;
    tree.octo = own(tree.octo);
    damage(tree);
    return complaint(tree);
  };
  for (std::size_t i = 0; i < good.octo.size(); ++i)
    for (std::uint32_t c = 0; c < kOctoArity; ++c) {
      EXPECT_NE(damaged([&](Bvh2& t) { t.octo[i].child[c] ^= 1; }), "");
      EXPECT_NE(damaged([&](Bvh2& t) { t.octo[i].child[c] = 0; }), "") << "a cycle";
      EXPECT_NE(damaged([&](Bvh2& t) { t.octo[i].leaf_mask ^= 1u << c; }), "");
      EXPECT_NE(damaged([&](Bvh2& t) { t.octo[i].child_mask ^= 1u << c; }), "");
      if (good.octo[i].child[c] == kNoNode) continue;
      EXPECT_NE(damaged([&](Bvh2& t) { t.octo[i].lower[1][c] = std::numeric_limits<float>::quiet_NaN(); }), "");
      if (is_leaf(good.octo[i].child[c])) {
        EXPECT_NE(damaged([&](Bvh2& t) { t.octo[i].upper[2][c] -= 0.25f * (1 + std::abs(t.octo[i].upper[2][c])); }), "");
      }
    }
  EXPECT_NE(damaged([](Bvh2& t) { t.octo.truncate(t.octo.size() - 1); }), "");
}

}  // namespace
}  // namespace accel
