// That the keys in the hash are those that the traversal may look up: none is missing (conformance/bvh2_laws_test.cpp), and
// here, that for each of them there is a tree of the same shape and a ray that look it up.
#include "libaccel/trace/bvh2_hash.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "libaccel/build/bvh2_hash.h"
#include "libaccel/build/bvh2_links.h"
#include "libaccel/exec/drive.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/structure/bvh2_walk.h"
#include "validation/stress/random_bvh2.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

// Sees whether the target is entered right after a look-up.
struct LookUpObserver : NullObserver {
  const Bvh2View* view;
  NodeRef target;
  bool looked_up = false, found = false;

  void load(Memory memory, const void* address, std::uint32_t) {
    if (memory == Memory::hash) looked_up = true;
    if (memory == Memory::node && !is_leaf(target) && address == view->nodes + target) found = looked_up;
  }
  void leaf_visit(std::uint32_t quad) {
    if (is_leaf(target) && quad == leaf_quad(target)) found = looked_up;
  }
};

const Aabb kMissed{{0, 50, 0}, {9, 51, 1}}, kNear{{1, -1, -1}, {2, 1, 1}}, kFar{{3, -1, -1}, {4, 1, 1}};
const Ray kRay{.org = {0, 0, 0}, .dir = {1, 0, 0}};

// Gives the tree boxes such that the ray postpones `target`, then a node three levels below its sibling, and comes back from
// there: see HashedKeys in structure/bvh2.h.
class Stage {
 public:
  explicit Stage(Bvh2& tree) : tree_(tree), parent_(tree.nodes.size(), kNoNode) {
    for (NodeRef i = 0; i < tree.nodes.size(); ++i)
      for (const NodeRef child : tree.nodes[i].child)
        if (!is_leaf(child)) parent_[child] = i;
  }

  void set(const Bvh2Place& target) {
    for (Bvh2Node& node : tree_.nodes)
      for (int c = 0; c < 2; ++c) node.set_bounds(c, kMissed);
    for (NodeRef node = target.parent; parent_[node] != kNoNode; node = parent_[node]) show(parent_[node], node, kNear);
    show(target.parent, target.sibling, kNear), show(target.parent, target.ref, kFar);
    NodeRef node = target.sibling;
    for (int levels = kHashedDistance; levels > 1; --levels) {
      const NodeRef next =
          tree_.nodes[node].child[has_inner_node_below(tree_.nodes.data(), tree_.nodes[node].child[0], levels - 1) ? 0 : 1];
      show(node, next, kNear);
      node = next;
    }
    const int last = is_leaf(tree_.nodes[node].child[0]) ? 1 : 0;  // comes second
    tree_.nodes[node].set_bounds(last, kFar), tree_.nodes[node].set_bounds(1 - last, kNear);
  }

 private:
  void show(NodeRef parent, NodeRef child, const Aabb& box) {
    tree_.nodes[parent].set_bounds(tree_.nodes[parent].child[0] == child ? 0 : 1, box);
  }

  Bvh2& tree_;
  std::vector<NodeRef> parent_;
};

TEST(Bvh2Hash, EveryKeyInTheHashCanBeLookedUp) {
  std::vector<Triangle> far_off = validation::random_triangles(150, 0.1f, 1);
  for (Triangle& t : far_off) t.v0.y += 90, t.v1.y += 90, t.v2.y += 90;
  const TriangleMesh mesh = validation::mesh_of(far_off);
  for (const validation::TreeShape shape : validation::kTreeShapes) {
    Bvh2 tree = validation::random_bvh2(mesh, 7, {.shape = shape, .leaf_size = 2});
    BuildReport report;
    add_links(tree, Bvh2Links::uncles);
    ASSERT_TRUE(add_hash(tree, HashedKeys::looked_up, report));
    std::vector<Bvh2Place> hashed;
    walk_bvh2(tree.view(), {.ref = tree.root}, tree.hash_multiplier, [&](const Bvh2Place& place) {
      if (place.sibling != kNoNode && has_inner_node_below(tree.nodes.data(), place.sibling, kHashedDistance))
        hashed.push_back(place);
      return true;
    });
    EXPECT_GT(hashed.size(), 10u);
    Stage stage(tree);
    const Bvh2View view = tree.view();
    for (const Bvh2Place& place : hashed) {
      stage.set(place);
      LookUpObserver observer;
      observer.view = &view, observer.target = place.ref;
      trace_ray<Bvh2Hash<Watertight, Query::closest>>(view, kRay, observer);
      ASSERT_TRUE(observer.found) << "shape " << static_cast<int>(shape) << ", node " << place.ref;
    }
  }
}

}  // namespace
}  // namespace accel
