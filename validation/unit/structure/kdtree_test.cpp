#include "libaccel/structure/kdtree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "libaccel/build/kdtree_links.h"
#include "libaccel/build/kdtree_ropes.h"
#include "libaccel/build/kdtree_sah.h"
#include "libaccel/structure/kdtree_stats.h"
#include "validation/unit/build/test_meshes.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

constexpr std::uint64_t kKdTreeTriangles = 200;

// A fresh valid tree with all that a tree can have.
KdTree valid_kdtree() {
  Result<Built<KdTree>> built = KdTreeSah::build(test::soup(kKdTreeTriangles, 0.2f), {});
  EXPECT_TRUE(built.ok());
  add_links(built->structure);
  add_ropes(built->structure);
  return std::move(built->structure);
}

// What validate() says about a tree that `corrupt` has changed; empty when it finds nothing.
std::string complaint(const std::function<void(KdTree&)>& corrupt) {
  KdTree tree = valid_kdtree();
  corrupt(tree);
  const Status status = validate(tree, kKdTreeTriangles);
  return status ? "" : status.message();
}

// The index of the last inner node with an inner child (leaf = false), or of the last leaf with references.
std::uint32_t last_of(const KdTree& tree, bool leaf) {
  for (auto i = static_cast<std::uint32_t>(tree.nodes.size()); i-- > 2;) {
    const KdNode node = tree.nodes[i];
    if (leaf && node.is_leaf() && node.first_reference() != kEmptyLeaf) return i;
    if (!leaf && !node.is_leaf() && !tree.nodes[node.lower_child()].is_leaf()) return i;
  }
  ADD_FAILURE();
  return 0;
}

void set_child(KdTree& tree, std::uint32_t node, std::uint32_t child) {
  tree.nodes[node] = KdNode::inner(tree.nodes[node].axis(), tree.nodes[node].plane(), child);
}

void set_plane(KdTree& tree, std::uint32_t node, float plane) {
  tree.nodes[node] = KdNode::inner(tree.nodes[node].axis(), plane, tree.nodes[node].lower_child());
}

template <class T>
Buffer<T> longer(const Buffer<T>& buffer, std::size_t size) {
  Buffer<T> result(size);
  for (std::size_t i = 0; i < size; ++i) result[i] = buffer[i % buffer.size()];
  return result;
}

TEST(ValidateKdTree, AcceptsTreesAndTheEmptyTree) {
  EXPECT_EQ(complaint([](KdTree&) {}), "");
  EXPECT_EQ(complaint([](KdTree& t) { t.parents = {}, t.cells = {}, t.ropes = {}; }), "");
  EXPECT_TRUE(validate(KdTree{}, 0).ok());
  for (const test::NamedMesh& named : test::all_meshes()) {
    KdTree tree = KdTreeSah::build(named.mesh, {}).value().structure;
    add_links(tree), add_ropes(tree);
    const Status status = validate(tree, named.mesh.size());
    EXPECT_TRUE(status.ok()) << named.name << ": " << status.message();
  }
}

TEST(ValidateKdTree, Children) {
  EXPECT_NE(complaint([](KdTree& t) { set_child(t, 0, 0); }), "");
  EXPECT_NE(complaint([](KdTree& t) { set_child(t, 0, 3); }), "");
  EXPECT_NE(complaint([](KdTree& t) { set_child(t, 0, 4); }), "");
  EXPECT_NE(complaint([](KdTree& t) { set_child(t, 0, (1u << 30) - 2); }), "");
  EXPECT_NE(complaint([](KdTree& t) { set_child(t, 0, static_cast<std::uint32_t>(t.nodes.size())); }), "");
  EXPECT_NE(complaint([](KdTree& t) { set_child(t, last_of(t, false), 2); }), "");
  EXPECT_NE(complaint([](KdTree& t) { set_child(t, last_of(t, false), t.nodes[0].lower_child()); }), "");
}

TEST(ValidateKdTree, UnreachableNodes) {
  EXPECT_NE(complaint([](KdTree& t) { t.nodes = longer(t.nodes, t.nodes.size() + 2); }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.nodes.truncate(t.nodes.size() - 1); }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.nodes.truncate(0); }), "");
}

TEST(ValidateKdTree, Planes) {
  for (const float plane : {kNaN, kInfinity, -kInfinity, 100.0f, -100.0f}) {
    EXPECT_NE(complaint([&](KdTree& t) { set_plane(t, 0, plane); }), "");
    EXPECT_NE(complaint([&](KdTree& t) { set_plane(t, last_of(t, false), plane); }), "");
  }
  EXPECT_NE(complaint([](KdTree& t) { set_plane(t, 0, t.bounds.lo[t.nodes[0].axis()]); }), "");
  EXPECT_NE(complaint([](KdTree& t) { set_plane(t, 0, t.bounds.hi[t.nodes[0].axis()]); }), "");
  for (const float bound : {kNaN, kInfinity, -100.0f}) EXPECT_NE(complaint([&](KdTree& t) { t.bounds.hi.y = bound; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.bounds.lo.z = -kInfinity; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.bounds.lo.x = t.bounds.hi.x; }), "");
}

TEST(ValidateKdTree, Leaves) {
  const auto change = [](std::uint32_t first_by, std::uint32_t ordinal_by) {
    return complaint([&](KdTree& t) {
      KdNode& leaf = t.nodes[last_of(t, true)];
      leaf = KdNode::leaf(leaf.first_reference() + first_by, leaf.ordinal() + ordinal_by);
    });
  };
  EXPECT_EQ(change(0, 0), "");
  EXPECT_NE(change(1, 0), "");
  EXPECT_NE(change(1u << 31, 0), "");
  EXPECT_NE(change(0, 1), "");
  EXPECT_NE(change(0, static_cast<std::uint32_t>(-1)), "");
  EXPECT_NE(complaint([](KdTree& t) { t.nodes[last_of(t, true)].payload = kEmptyLeaf; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.nodes[last_of(t, true)].payload = 0; }), "");
}

TEST(ValidateKdTree, ReferencesAndTriangles) {
  const auto last = [](KdTree& t) -> std::uint32_t& { return t.leaves.references[t.leaves.references.size() - 1]; };
  EXPECT_NE(complaint([&](KdTree& t) { last(t) &= ~kLastReference; }), "");
  EXPECT_NE(complaint([&](KdTree& t) { last(t) = kLastReference | kKdTreeTriangles; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.leaves.references.truncate(t.leaves.references.size() - 1); }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.leaves.triangles.truncate(kKdTreeTriangles - 1); }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.leaves.triangles[7].axis[0].word = kKdTreeTriangles; }), "");
}

TEST(ValidateKdTree, Counts) {
  EXPECT_NE(complaint([](KdTree& t) { t.depth += 1; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.depth -= 1; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.leaf_count += 1, t.ropes = {}; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.leaf_count -= 1, t.ropes = {}; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.leaf_count = 0xffffffffu, t.ropes = {}; }), "");
}

TEST(ValidateKdTree, ParentsAndCells) {
  EXPECT_NE(complaint([](KdTree& t) { t.parents = {}; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.cells = {}; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.parents.truncate(3), t.cells.truncate(3); }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.parents[5] += 1; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.parents[t.parents.size() - 1] = 0xffffffffu; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.cells[5].hi.x += 1; }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.cells[5].lo.z = std::numeric_limits<float>::quiet_NaN(); }), "");
}

TEST(ValidateKdTree, Ropes) {
  EXPECT_NE(complaint([](KdTree& t) { t.ropes.truncate(t.ropes.size() - 1); }), "");
  EXPECT_NE(complaint([](KdTree& t) { t.ropes[3].cell.lo.y -= 1; }), "");
  for (const std::uint32_t rope : {1u, 0u, kNoRope, 0xfffffffeu}) {
    for (int face = 0; face < 6; ++face)
      EXPECT_NE(complaint([&](KdTree& t) {
                  for (LeafRopes& ropes : t.ropes)
                    if (ropes.rope[face] != kNoRope) return void(ropes.rope[face] = rope);
                }),
                "");
  }
  // A rope where the tree ends.
  EXPECT_NE(complaint([](KdTree& t) {
              for (LeafRopes& ropes : t.ropes)
                if (ropes.rope[0] == kNoRope) return void(ropes.rope[0] = 2);
            }),
            "");
}

// A chain of a million nodes: neither validate() nor the statistics may recurse.
KdTree kdtree_chain(std::uint32_t length) {
  KdTree tree;
  tree.nodes = Buffer<KdNode>(2 * (length + 1));
  tree.nodes[1] = KdNode::leaf(kEmptyLeaf, 0);
  for (std::uint32_t i = 0; i < length; ++i) {
    const std::uint32_t node = i == 0 ? 0 : 2 * i + 1;
    tree.nodes[node] = KdNode::inner(0, static_cast<float>(i + 1), 2 * (i + 1));
    tree.nodes[2 * (i + 1)] = KdNode::leaf(kEmptyLeaf, i);
  }
  tree.nodes[2 * length + 1] = KdNode::leaf(kEmptyLeaf, length);
  tree.bounds = {{0, 0, 0}, {static_cast<float>(length + 1), 1, 1}};
  tree.depth = length, tree.leaf_count = length + 1;
  return tree;
}

TEST(ValidateKdTree, ALongChainDoesNotOverflowTheStack) {
  const KdTree tree = kdtree_chain(1000000);
  const Status status = validate(tree, 0);
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(kdtree_stats(tree).depth, 1000000u);
}

TEST(KdTree, ExtrasArePartOfItsSize) {
  KdTree tree = valid_kdtree();
  EXPECT_TRUE(tree.has(KdExtras::parents_and_boxes) && tree.has(KdExtras::ropes));
  const std::size_t all = tree.size_bytes(), ropes = tree.ropes.size_bytes();
  tree.ropes = {};
  EXPECT_FALSE(tree.has(KdExtras::ropes));
  EXPECT_EQ(tree.size_bytes(), all - ropes);
}

}  // namespace
}  // namespace accel
