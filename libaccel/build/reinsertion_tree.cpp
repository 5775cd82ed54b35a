#include "libaccel/build/reinsertion_tree.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "libaccel/build/parallel.h"
#include "libaccel/structure/bvh2_walk.h"

namespace accel {
namespace {

Aabb box_of_children(const Bvh2Node& node) {
  Aabb box = node.bounds(0);
  box.extend(node.bounds(1));
  return box;
}

bool same_box(const Aabb& a, const Aabb& b) { return a.contains(b) && b.contains(a); }

}  // namespace

ReinsertionTree::ReinsertionTree(Bvh2& bvh, std::uint32_t most_levels)
    : nodes_(std::move(bvh.nodes)),
      root_(bvh.root),
      root_box_(bvh.bounds),
      most_levels_(std::max(most_levels, bvh.depth)),
      slots_(2 * nodes_.size() + 1),
      quads_(nodes_.size() + 1),
      levels_(nodes_.size()) {
  number_leaves();
  tighten_boxes();
  measure_levels();
  measure_leaves(bvh);
}

// Leaves get the numbers of their turn, and all get their slots.
void ReinsertionTree::number_leaves() {
  std::uint32_t leaves = 0;
  if (!is_leaf(root_)) slots_[root_] = kRootSlot;
  for (std::uint32_t i = 0; i < node_count(); ++i)
    for (std::uint32_t side = 0; side < 2; ++side) {
      NodeRef& child = nodes_[i].child[side];
      if (is_leaf(child)) {
        quads_[leaves] = leaf_quad(child);
        child = leaf_ref(leaves++);
      }
      slots_[is_leaf(child) ? node_count() + leaf_quad(child) : child] = 2 * i + side;
    }
}

// Where spatial splits clipped triangles, the boxes of nodes may be larger than what is in them.
void ReinsertionTree::tighten_boxes() {
  for (std::uint32_t i = node_count(); i-- > 0;) {
    const Aabb box = box_of_children(nodes_[i]);
    inner_area_before_ += half_area_in_double(box_at(slots_[i]));
    inner_area_ += half_area_in_double(box);
    put(slots_[i], i, box);
  }
}

void ReinsertionTree::measure_levels() {
  for (std::uint32_t i = node_count(); i-- > 0;)
    levels_[i] = 1 + std::max(levels(nodes_[i].child[0]), levels(nodes_[i].child[1]));
}

void ReinsertionTree::measure_leaves(const Bvh2& bvh) {
  leaf_area_ = reduce_chunks<double>(0, quads_.size(), [&](std::size_t begin, std::size_t end) {
    double area = 0;
    for (auto leaf = static_cast<std::uint32_t>(begin); leaf < end; ++leaf) {
      const std::uint32_t quad = quads_[leaf], terminator = terminator_of(bvh.leaves.data(), leaf_ref(quad));
      const std::uint32_t triangles = (terminator - quad) / kQuadsPerTriangle;
      area += half_area_in_double(box_at(slot_of(leaf_ref(leaf)))) * triangles;
    }
    return area;
  });
}

void ReinsertionTree::give_back(Bvh2& bvh) {
  number_nodes();
  measure_levels();
  std::vector<std::uint32_t> first(quads_.size() + 1);
  for_chunks(0, quads_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t leaf = begin; leaf < end; ++leaf)
      first[leaf + 1] = terminator_of(bvh.leaves.data(), leaf_ref(quads_[leaf])) + 1 - quads_[leaf];
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  Buffer<LeafQuad> leaves(bvh.leaves.size());
  for_chunks(0, quads_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t leaf = begin; leaf < end; ++leaf)
      std::copy_n(bvh.leaves.data() + quads_[leaf], first[leaf + 1] - first[leaf], leaves.data() + first[leaf]);
  });
  for (Bvh2Node& node : nodes_)
    for (NodeRef& child : node.child)
      if (is_leaf(child)) child = leaf_ref(first[leaf_quad(child)]);
  bvh.root = root_;
  bvh.depth = levels(root_);
  bvh.nodes = std::move(nodes_);
  bvh.leaves = std::move(leaves);
}

bool ReinsertionTree::improve(NodeRef subtree, NodeRef target) {
  if (!may_move(subtree, target)) return false;
  const NodeRef sibling = sibling_of(subtree);
  const double saved = move(subtree, target);
  if (saved > 0) {
    inner_area_ -= saved;
    return true;
  }
  move(subtree, sibling);  // back
  return false;
}

bool ReinsertionTree::may_move(NodeRef subtree, NodeRef target) const {
  if (subtree == root_ || subtree == target) return false;
  const NodeRef parent = slot_of(subtree) / 2;
  if (target == parent || target == sibling_of(subtree)) return false;
  std::uint32_t above = 0;  // inner nodes
  for (Slot slot = slot_of(target); slot != kRootSlot; slot = slots_[slot / 2], ++above)
    if (slot / 2 == subtree) return false;
  return above + 1 + std::max(levels(subtree), levels(target)) <= most_levels_;
}

// Returns by how much the sum of the inner nodes' areas gets smaller.
double ReinsertionTree::move(NodeRef subtree, NodeRef target) {
  const Slot from = slot_of(subtree);
  const NodeRef parent = from / 2;
  const Aabb box = box_at(from), sibling_box = box_at(from ^ 1u);
  const Slot above = slot_of(parent);
  double saved = half_area_in_double(box_at(above));
  put(above, ref_at(from ^ 1u), sibling_box);
  saved += tighten_above(above);

  const Slot to = slot_of(target);
  Aabb merged = box_at(to);
  put(2 * parent, target, merged), put(2 * parent + 1, subtree, box);
  merged.extend(box);
  saved -= half_area_in_double(merged);
  put(to, parent, merged);
  saved += tighten_above(to);
  raise_above(parent);
  return saved;
}

// Boxes above a slot whose box has changed. Returns by how much their areas get smaller.
double ReinsertionTree::tighten_above(Slot slot) {
  double saved = 0;
  while (slot != kRootSlot) {
    const NodeRef inner = slot / 2;
    slot = slots_[inner];
    const Aabb old = box_at(slot), box = box_of_children(nodes_[inner]);
    if (same_box(old, box)) break;
    saved += half_area_in_double(old) - half_area_in_double(box);
    put(slot, inner, box);
  }
  return saved;
}

void ReinsertionTree::put(Slot slot, NodeRef ref, const Aabb& box) {
  slots_[is_leaf(ref) ? node_count() + leaf_quad(ref) : ref] = slot;
  if (slot == kRootSlot) {
    root_ = ref, root_box_ = box;
  } else {
    nodes_[slot / 2].child[slot % 2] = ref;
    nodes_[slot / 2].set_bounds(static_cast<int>(slot % 2), box);
  }
}

// Levels that a new inner node adds. Those that a subtree takes away where it leaves are not looked for.
void ReinsertionTree::raise_above(NodeRef inner) {
  levels_[inner] = 1 + std::max(levels(nodes_[inner].child[0]), levels(nodes_[inner].child[1]));
  for (Slot slot = slots_[inner]; slot != kRootSlot; slot = slots_[slot / 2]) {
    const std::uint32_t raised = levels(ref_at(slot)) + 1;
    if (levels_[slot / 2] >= raised) break;
    levels_[slot / 2] = raised;
  }
}

// Numbers nodes and leaves anew; slots are given up.
void ReinsertionTree::number_nodes() {
  struct Pending {
    NodeRef ref;  // as it was
    Slot slot;    // as it will be
  };
  Buffer<Bvh2Node> nodes(nodes_.size());
  std::vector<std::uint32_t> quads(quads_.size());
  std::vector<Pending> pending{{root_, kRootSlot}};
  std::uint32_t inner = 0, leaf = 0;
  while (!pending.empty()) {
    const auto [ref, slot] = pending.back();
    pending.pop_back();
    const NodeRef numbered = is_leaf(ref) ? leaf_ref(leaf) : inner;
    if (slot == kRootSlot)
      root_ = numbered;
    else
      nodes[slot / 2].child[slot % 2] = numbered;
    if (is_leaf(ref)) {
      quads[leaf++] = quads_[leaf_quad(ref)];
      continue;
    }
    const Bvh2Node& old = nodes_[ref];
    const int first = half_area_in_double(old.bounds(0)) < half_area_in_double(old.bounds(1)) ? 1 : 0;
    nodes[inner] = {};
    for (const int side : {1, 0}) {
      nodes[inner].set_bounds(side, old.bounds(side ^ first));
      pending.push_back({old.child[side ^ first], 2 * inner + static_cast<Slot>(side)});
    }
    ++inner;
  }
  nodes_ = std::move(nodes), quads_ = std::move(quads);
}

}  // namespace accel
