// Where the nodes and blocks of a wide tree are, however it is cut into pieces.
#include "libaccel/build/wide_layout.h"

#include <gtest/gtest.h>

#include "libaccel/build/wide_sbvh.h"
#include "validation/unit/build/builder_checks.h"

namespace accel {
namespace {

// Counts nodes and blocks in the order that the layout has: those of a node's children, then what is below each child.
class Walk {
 public:
  explicit Walk(const Bvh8& bvh) : bvh_(bvh) {}

  void expect_below(NodeRef ref, std::uint32_t depth) {
    const Bvh8Node& node = bvh_.nodes[ref];
    deepest_ = std::max(deepest_, depth);
    for (const NodeRef child : node.child) {
      if (child == kNoNode) continue;
      if (!is_leaf(child)) {
        EXPECT_EQ(child, next_node_++);
        continue;
      }
      EXPECT_EQ(first_block(child), next_block_);
      next_block_ += block_count(bvh_.blocks, child);
      next_block_ += counted_blocks(child) == 0 ? 1 : 0;
    }
    for (const NodeRef child : node.child)
      if (child != kNoNode && !is_leaf(child)) expect_below(child, depth + 1);
  }
  void expect_end() const {
    EXPECT_EQ(next_node_, bvh_.nodes.size());
    EXPECT_EQ(next_block_, bvh_.blocks.size());
    EXPECT_EQ(deepest_, bvh_.depth);
  }

 private:
  const Bvh8& bvh_;
  std::uint32_t next_node_ = 1, deepest_ = 0;
  std::size_t next_block_ = 0;
};

TEST(WideLayout, ChildrenFollowEachOtherDepthFirst) {
  for (const std::uint32_t triangles : {9u, 60u, 700u, 20000u})
    for (const int max_leaf_size : {1, 8, 100}) {
      const Bvh8 bvh = test::build<WideSbvh>(test::soup(triangles, 0.05f), {.max_leaf_size = max_leaf_size}).structure;
      if (is_leaf(bvh.root)) continue;
      ASSERT_EQ(bvh.root, 0u);
      Walk walk(bvh);
      walk.expect_below(bvh.root, 1);
      walk.expect_end();
    }
}

}  // namespace
}  // namespace accel
