#include "libaccel/structure/bvh8.h"

#include <algorithm>
#include <string>
#include <vector>

#include "libaccel/structure/bvh8_coded.h"

namespace accel {
namespace {

// Whether every coordinate is NaN.
bool is_untestable(const PackedTriangle& triangle) {
  for (int a = 0; a < 3; ++a)
    for (const float x : triangle.axis[a].vertex)
      if (x == x) return false;
  return true;
}

// Whether the vertices that a lane names can be read: 16 bytes of each.
template <class Node>
bool has_vertices(const Bvh8Of<Node>& bvh, const typename Node::Block& triangles, std::uint32_t lane) {
  if constexpr (Node::Block::kIsIndexed)
    for (const auto& vertex : triangles.vertex)
      if (std::uint64_t{vertex[lane]} + 1 >= bvh.vertices.size()) return false;
  return true;
}

// How many triangles a block has, or an error where it is none: a gap, or a vertex or prim_id beyond those there are.
template <class Node>
Result<std::uint32_t> triangles_of(const Bvh8Of<Node>& bvh, std::uint32_t block, std::uint64_t triangle_count) {
  const typename Node::Block& triangles = bvh.blocks[block];
  std::uint32_t count = 0;
  for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane) {
    if (!has_vertices(bvh, triangles, lane))
      return Error{"block " + std::to_string(block) + " names a vertex that is not one of " +
                   std::to_string(bvh.vertices.size()) + ", or the last"};
    if (!triangles.has(lane)) {
      if (!is_untestable(bvh.view().packed(triangles, lane)))
        return Error{"block " + std::to_string(block) + " has a triangle without a prim_id"};
      continue;
    }
    if (lane != count) return Error{"block " + std::to_string(block) + " has a gap before a triangle"};
    if (triangles.prim_id[lane] >= triangle_count)
      return Error{"block " + std::to_string(block) + " names triangle " + std::to_string(triangles.prim_id[lane]) +
                   ", but there are " + std::to_string(triangle_count)};
    ++count;
  }
  return count;
}

// Follows all references from the root, each once. Iterative: a hostile file may be a chain of a hundred million nodes.
template <class Node>
class Bvh8Walk {
 public:
  Bvh8Walk(const Bvh8Of<Node>& bvh, std::uint64_t triangle_count)
      : bvh_(bvh), triangle_count_(triangle_count), seen_(bvh.nodes.size()), used_(bvh.blocks.size()) {}

  Status run() {
    pending_.push_back({bvh_.root, 0, bvh_.bounds});
    while (!pending_.empty()) {
      const Pending next = pending_.back();
      pending_.pop_back();
      Status status = is_leaf(next.ref) ? visit_leaf(next) : visit_node(next);
      if (!status) return status;
    }
    return check_totals();
  }

 private:
  struct Pending {
    NodeRef ref;
    std::uint32_t above;  // inner nodes on the path so far
    Aabb box;
  };

  Status check_totals() const {
    if (nodes_ != bvh_.nodes.size())
      return Error{"the root reaches " + std::to_string(nodes_) + " nodes, but there are " + std::to_string(bvh_.nodes.size())};
    if (blocks_ != bvh_.blocks.size())
      return Error{"the root reaches " + std::to_string(blocks_) + " blocks of triangles, but there are " +
                   std::to_string(bvh_.blocks.size())};
    if (depth_ != bvh_.depth)
      return Error{"the longest path has " + std::to_string(depth_) + " nodes, but depth is " + std::to_string(bvh_.depth)};
    if (references_ != bvh_.references)
      return Error{"the leaves hold " + std::to_string(references_) + " triangles, but references is " +
                   std::to_string(bvh_.references)};
    return Done{};
  }

  Status visit_leaf(const Pending& leaf) {
    depth_ = std::max(depth_, leaf.above);
    const std::uint32_t counted = counted_blocks(leaf.ref);
    std::uint32_t block = first_block(leaf.ref);
    const std::string name = "the leaf at block " + std::to_string(block);
    if (counted > kMostCounted) return Error{name + " counts " + std::to_string(counted) + " blocks"};
    for (std::uint32_t i = 0; counted == 0 || i < counted; ++i, ++block) {
      if (block >= used_.size()) return Error{name + " reaches beyond the last of " + std::to_string(used_.size()) + " blocks"};
      if (used_[block]) return Error{"block " + std::to_string(block) + " belongs to more than one leaf"};
      used_[block] = true, ++blocks_;
      const Result<std::uint32_t> triangles = triangles_of(bvh_, block, triangle_count_);
      if (!triangles) return triangles.error();
      references_ += *triangles;
      const bool is_end = counted == 0 && i > kMostCounted && *triangles == 0;
      if (is_end) return Done{};
      if (*triangles == 0) return Error{name + " has a block without triangles"};
    }
    return Done{};
  }

  Status visit_node(const Pending& inner) {
    const std::string name = "node " + std::to_string(inner.ref);
    if (inner.ref >= seen_.size())
      return Error{"a child reference names " + name + ", but there are " + std::to_string(seen_.size())};
    if (seen_[inner.ref]) return Error{name + " is the child of more than one node, or the root"};
    seen_[inner.ref] = true, ++nodes_;
    const Node& node = bvh_.nodes[inner.ref];
    if (!is_ordered(node)) return Error{name + " has an order of children that is no permutation"};
    std::uint32_t children = 0;
    for (std::uint32_t c = 0; c < kBvh8Arity; ++c) {
      const std::string child = name + " has a box for child " + std::to_string(c);
      const Aabb box = node.bounds(c);
      if (node.child[c] == kNoNode) {
        if (!node.is_absent(c)) return Error{child + ", which there is none"};
        continue;
      }
      if (c != children++) return Error{name + " has a gap before child " + std::to_string(c)};
      if (box.empty()) return Error{child + " that is inverted or NaN"};
      if (Node::kIsExact && !inner.box.contains(box)) return Error{child + " that is not in the node's own"};
      pending_.push_back({node.child[c], inner.above + 1, box});
    }
    if (children == 0) return Error{name + " has no children"};
    return Done{};
  }

  static bool is_ordered(const Node& node) {
    for (std::uint32_t octant = 0; octant < kBvh8Arity; ++octant) {
      std::uint32_t named = 0;
      for (std::uint32_t i = 0; i < kBvh8Arity; ++i) named |= 1u << node.ordered(i, octant);
      if (named != 0xffu) return false;
    }
    return true;
  }

  const Bvh8Of<Node>& bvh_;
  const std::uint64_t triangle_count_;
  std::vector<bool> seen_, used_;
  std::vector<Pending> pending_;
  std::uint64_t nodes_ = 0, blocks_ = 0, references_ = 0;
  std::uint32_t depth_ = 0;
};

}  // namespace

template <class Node>
Status validate(const Bvh8Of<Node>& bvh, std::uint64_t triangle_count) {
  if (bvh.nodes.size() >= kLeafBit || bvh.blocks.size() > kMaxBlocks)
    return Error{"more nodes or blocks of triangles than a reference can name"};
  if (bvh.root == kNoNode) {
    if (bytes_of_arrays(bvh) == 0 && bvh.depth == 0 && bvh.references == 0) return Done{};
    return Error{"there is no root, but there are nodes or leaves"};
  }
  if (bvh.bounds.empty()) return Error{"the box of the whole tree is inverted or NaN"};
  return Bvh8Walk<Node>(bvh, triangle_count).run();
}

template Status validate(const Bvh8&, std::uint64_t);
template Status validate(const Bvh8Byte&, std::uint64_t);
template Status validate(const Bvh8Half&, std::uint64_t);
template Status validate(const Bvh8Compact&, std::uint64_t);

}  // namespace accel
