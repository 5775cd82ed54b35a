#include "libaccel/packet/depth_first.h"

#include <gtest/gtest.h>

#include "validation/unit/packet/packets_of_rays.h"

namespace accel {
namespace {

using test::Pairs;

template <class Tree, class Children>
Pairs traverse_depth_first(const Bvh2& tree, const std::vector<Frustum>& frustums) {
  DepthFirst<Tree, Children> traversal;
  traversal.run(tree.view(), frustums.data(), 1);  // what is left of it is forgotten
  const auto& leaves = traversal.run(tree.view(), frustums.data(), frustums.size());
  Pairs pairs;
  for (std::size_t i = 0; i < leaves.place.size(); ++i) pairs.push_back({leaves.frustum[i], leaves.place[i]});
  return pairs;
}

TEST(DepthFirst, FindsWhatARecursiveWalkFindsInTheSameOrder) {
  std::size_t found = 0;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh2 tree = test::octo_tree(mesh);
    if (tree.octo.empty()) continue;
    const std::vector<Frustum> frustums = test::frustums_for(mesh, tree.bounds, 5);
    const Pairs octo = test::walk<OctoTree>(tree, frustums);
    EXPECT_EQ((traverse_depth_first<OctoTree, ScalarChildren<OctoTree>>(tree, frustums)), octo) << name;
    EXPECT_EQ((traverse_depth_first<OctoTree, SimdChildren>(tree, frustums)), octo) << name;
    EXPECT_EQ((traverse_depth_first<BinaryTree, ScalarChildren<BinaryTree>>(tree, frustums)),
              test::walk<BinaryTree>(tree, frustums))
        << name;
    found += octo.size();
  }
  EXPECT_GT(found, 10000u);
}

}  // namespace
}  // namespace accel
