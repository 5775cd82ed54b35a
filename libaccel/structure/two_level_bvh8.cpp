#include "libaccel/structure/two_level_bvh8.h"

#include <algorithm>
#include <span>
#include <string>

namespace accel {
namespace {

// A node that no tree has.
constexpr NodeRef kNowhere = kLeafBit - 1;

bool is_block(NodeRef ref) { return is_leaf(ref) && counted_blocks(ref) <= kMostCounted; }

// A reference whose node or block has moved by so many places. kNoNode and instances stay.
NodeRef moved(NodeRef ref, std::uint64_t nodes, std::uint64_t blocks) {
  if (!is_leaf(ref)) return static_cast<NodeRef>(ref + nodes);
  return is_block(ref) ? static_cast<NodeRef>(ref + blocks) : ref;
}

// Nodes, whose references move by so many places.
void copy_nodes(std::span<const Bvh8Node> from, std::uint64_t nodes, std::uint64_t blocks, Bvh8Node* to) {
  for (const Bvh8Node& node : from) {
    *to = node;
    for (NodeRef& child : to->child) child = moved(child, nodes, blocks);
    ++to;
  }
}

// Those of a tree, as they count from its own first node and block.
NodeRef within(const Bvh8Tree& tree, NodeRef ref) {
  const std::uint64_t place = is_leaf(ref) ? first_block(ref) : ref;
  const std::uint64_t first = is_leaf(ref) ? tree.first_block : tree.first_node,
                      count = is_leaf(ref) ? tree.blocks : tree.nodes;
  if ((is_leaf(ref) && !is_block(ref)) || place < first || place - first >= count) return kNowhere;
  return static_cast<NodeRef>(ref - first);
}

// The tree over instances, with blocks of stand-ins for its runs.
class TopTree {
 public:
  explicit TopTree(const TwoLevelBvh8& bvh) : bvh_(bvh), leaf_at_(bvh.instances.size(), kNowhere) {
    for (std::uint32_t begin = 0, end = 0; begin < bvh.instances.size(); begin = end) {
      while (end < bvh.instances.size() && bvh.instances[end].ends_leaf == 0) ++end;
      if (end == bvh.instances.size()) break;  // without an end: no leaf
      add_leaf(begin, ++end);
    }
  }

  NodeRef leaf(NodeRef ref) const {
    const std::uint32_t number = instance_number(ref);
    return is_instance(ref) && number < leaf_at_.size() ? leaf_at_[number] : kNowhere;
  }
  Buffer<TriangleBlock> blocks() const { return Buffer<TriangleBlock>::copy_of(blocks_); }

 private:
  void add_leaf(std::uint32_t begin, std::uint32_t end) {
    const auto first = static_cast<std::uint32_t>(blocks_.size());
    for (std::uint32_t i = begin; i < end; i += kBlockLanes) add_block(i, std::min(i + kBlockLanes, end));
    const auto count = static_cast<std::uint32_t>(blocks_.size()) - first;
    if (count > kMostCounted) add_block(end, end);
    leaf_at_[begin] = block_ref(first, count);
  }
  void add_block(std::uint32_t begin, std::uint32_t end) {
    TriangleBlock& block = blocks_.emplace_back();
    for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane)
      if (begin + lane < end)
        block.set(lane, {{{{0, 0, 0}, begin + lane}, {{0, 0, 0}, 0}, {{0, 0, 0}, 0}}});
      else
        block.clear(lane);
  }

  const TwoLevelBvh8& bvh_;
  std::vector<NodeRef> leaf_at_;  // by the first instance of a run
  std::vector<TriangleBlock> blocks_;
};

Status validate_trees(const TwoLevelBvh8& bvh) {
  std::uint64_t nodes = 0, blocks = 0;
  std::uint32_t depth = 0;
  for (std::size_t i = 0; i < bvh.trees.size(); ++i) {
    const Bvh8Tree& t = bvh.trees[i];
    const std::string name = "tree " + std::to_string(i);
    if (t.first_node != nodes || t.first_block != blocks || t.nodes > bvh.nodes.size() - nodes ||
        t.blocks > bvh.blocks.size() - blocks || (i == 0 && t.blocks > 0))
      return Error{name + " is not the part of the arrays that comes after the tree before it"};
    nodes += t.nodes, blocks += t.blocks;
    if (const Status valid = validate(bvh.tree(i), t.triangles); !valid) return Error{name + ": " + valid.message()};
    depth = std::max(depth, t.depth);
  }
  if (nodes != bvh.nodes.size() || blocks != bvh.blocks.size())
    return Error{"there are nodes or blocks of triangles that belong to no tree"};
  if (depth != bvh.depth || bvh.trees[0].root != bvh.root) return Error{"the root and the depth are not those of the trees"};
  return Done{};
}

Status validate_instances(const TwoLevelBvh8& bvh, std::uint64_t triangle_count) {
  if (bvh.instances.size() > kMostInstances) return Error{"more instances than a reference can name"};
  if (!bvh.instances.empty() && bvh.instances[bvh.instances.size() - 1].ends_leaf == 0)
    return Error{"the last instance does not end a leaf"};
  for (std::size_t i = 0; i < bvh.instances.size(); ++i) {
    const Bvh8Instance& instance = bvh.instances[i];
    const std::string name = "instance " + std::to_string(i);
    if (instance.tree == 0 || instance.tree >= bvh.trees.size())
      return Error{name + " names tree " + std::to_string(instance.tree) + ", which is none of a mesh"};
    const Bvh8Tree& tree = bvh.trees[instance.tree];
    if (instance.root != tree.root || tree.root == kNoNode) return Error{name + " does not begin at the root of its tree"};
    if (!is_finite(instance.to_object)) return Error{name + " has a map that is not finite"};
    if (instance.first_prim > triangle_count || tree.triangles > triangle_count - instance.first_prim)
      return Error{name + " has triangles that the scene has not"};
  }
  return Done{};
}

Status check_sizes(std::uint64_t nodes, std::uint64_t blocks, std::uint64_t instances) {
  if (nodes < kLeafBit && blocks <= kMaxBlocks && instances <= kMostInstances) return Done{};
  return Error{"the trees have " + std::to_string(nodes) + " nodes, " + std::to_string(blocks) + " blocks of triangles and " +
               std::to_string(instances) + " instances, more than a reference can name"};
}

}  // namespace

Bvh8 TwoLevelBvh8::tree(std::size_t i) const {
  const Bvh8Tree& t = trees[i];
  Bvh8 bvh;
  static_cast<Bvh8Words&>(bvh) = t;
  bvh.nodes = Buffer<Bvh8Node>::copy_of(nodes.part(t.first_node, t.nodes).span());
  const auto move_all = [&](const auto& move) {
    if (t.root != kNoNode) bvh.root = move(t.root);
    for (Bvh8Node& node : bvh.nodes)
      for (NodeRef& child : node.child)
        if (child != kNoNode) child = move(child);
  };
  if (i > 0) {
    bvh.blocks = blocks.part(t.first_block, t.blocks);
    move_all([&](NodeRef ref) { return within(t, ref); });
  } else {
    const TopTree top(*this);
    bvh.blocks = top.blocks();
    move_all([&](NodeRef ref) { return is_leaf(ref) ? top.leaf(ref) : ref; });
  }
  return bvh;
}

Result<TwoLevelBvh8> TwoLevelBvh8::join(const std::vector<Bvh8>& trees, const std::vector<std::uint64_t>& triangles,
                                        const Buffer<Bvh8Instance>& instances) {
  TwoLevelBvh8 result;
  if (trees.empty()) return result;
  result.trees = Buffer<Bvh8Tree>(trees.size());
  std::uint64_t nodes = 0, blocks = 0;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    Bvh8Tree& t = result.trees[i];
    t = {trees[i], nodes, trees[i].nodes.size(), blocks, i == 0 ? 0 : trees[i].blocks.size(), triangles[i]};
    nodes += t.nodes, blocks += t.blocks;
    result.depth = std::max(result.depth, t.depth);
  }
  if (const Status fits = check_sizes(nodes, blocks, instances.size()); !fits) return fits.error();
  result.nodes = Buffer<Bvh8Node>(nodes), result.blocks = Buffer<TriangleBlock>(blocks);
  for (std::size_t i = 1; i < trees.size(); ++i) {
    Bvh8Tree& t = result.trees[i];
    t.root = moved(t.root, t.first_node, t.first_block);
    std::copy(trees[i].blocks.begin(), trees[i].blocks.end(), result.blocks.begin() + t.first_block);
    copy_nodes(trees[i].nodes.span(), t.first_node, t.first_block, result.nodes.data() + t.first_node);
  }

  result.place_top(trees[0], instances);
  return result;
}

Result<TwoLevelBvh8> TwoLevelBvh8::with_top(const Bvh8& top, const Buffer<Bvh8Instance>& with) const {
  const std::uint64_t before = trees.empty() ? 0 : trees[0].nodes, nodes_of_meshes = nodes.size() - before;
  if (const Status fits = check_sizes(nodes_of_meshes + top.nodes.size(), blocks.size(), with.size()); !fits)
    return fits.error();
  TwoLevelBvh8 result;
  result.blocks = blocks;
  result.trees = Buffer<Bvh8Tree>(std::max<std::size_t>(trees.size(), 1));
  result.trees[0] = {top, 0, top.nodes.size(), 0, 0, 0};
  result.depth = top.depth;

  const std::uint64_t further = top.nodes.size() - before;  // modulo 2^64, as places are modulo 2^32
  for (std::size_t i = 1; i < trees.size(); ++i) {
    Bvh8Tree& t = result.trees[i];
    t = trees[i];
    t.first_node += further, t.root = moved(t.root, further, 0);
    result.depth = std::max(result.depth, t.depth);
  }
  result.nodes = Buffer<Bvh8Node>(nodes_of_meshes + top.nodes.size());
  copy_nodes(nodes.span().subspan(before), further, 0, result.nodes.data() + top.nodes.size());
  result.place_top(top, with);
  return result;
}

void TwoLevelBvh8::place_top(const Bvh8& top, const Buffer<Bvh8Instance>& with) {
  // Runs of instances, in the order in which the tree over them names them.
  instances = Buffer<Bvh8Instance>(top.references);
  std::uint32_t count = 0;
  const auto add_run = [&](NodeRef leaf) {
    const NodeRef ref = instance_ref(count);
    const std::uint32_t first = first_block(leaf), end = first + block_count(top.blocks, leaf);
    for (std::uint32_t b = first; b < end; ++b)
      for (std::uint32_t lane = 0; lane < kBlockLanes && top.blocks[b].has(lane); ++lane) {
        Bvh8Instance& instance = instances[count++];
        instance = with[top.blocks[b].prim_id[lane]];
        instance.root = trees[instance.tree].root, instance.ends_leaf = 0;
      }
    instances[count - 1].ends_leaf = 1;
    return ref;
  };
  Bvh8Tree& t = trees[0];
  if (t.root != kNoNode && is_leaf(t.root)) t.root = add_run(t.root);
  for (std::size_t n = 0; n < t.nodes; ++n) {
    nodes[n] = top.nodes[n];
    for (NodeRef& child : nodes[n].child)
      if (is_leaf(child) && child != kNoNode) child = add_run(child);
  }
  t.triangles = count;
  root = t.root;
}

Status validate(const TwoLevelBvh8& bvh, std::uint64_t triangle_count) {
  if (bvh.nodes.size() >= kLeafBit || bvh.blocks.size() > kMaxBlocks)
    return Error{"more nodes or blocks of triangles than a reference can name"};
  if (bvh.trees.empty()) {
    if (bytes_of_arrays(bvh) == 0 && triangle_count == 0 && bvh.root == kNoNode) return Done{};
    return Error{"there is no tree, but there are nodes, blocks, instances or triangles"};
  }
  if (bvh.trees[0].triangles != bvh.instances.size())
    return Error{"the tree over instances is one over " + std::to_string(bvh.trees[0].triangles) + ", but there are " +
                 std::to_string(bvh.instances.size())};
  if (const Status good = validate_instances(bvh, triangle_count); !good) return good;
  return validate_trees(bvh);
}

}  // namespace accel
