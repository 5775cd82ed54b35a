#include "libaccel/build/emit_kdtree.h"

#include <algorithm>

#include <tbb/parallel_for.h>

#include "libaccel/build/kdtree_layout.h"
#include "libaccel/build/parallel.h"

namespace accel {
namespace {

// Where a treelet's nodes, references and leaves go.
struct TreeletPlacement {
  const KdTreelet* treelet;
  std::uint64_t first_node, first_reference, first_leaf;
  std::uint64_t root = 0;  // where its root goes: the pair of an upper node
};

// The final places of all subtrees, in depth-first order.
struct TreeletLayout {
  std::vector<TreeletPlacement> placements;
  std::uint64_t nodes = 2, references = 0, leaves = 0;  // the root has a pair of its own

  void visit(const KdSubtree& tree) {
    if (!tree.is_treelet()) {
      nodes += 2;
      visit(*tree.child[0]), visit(*tree.child[1]);
      return;
    }
    placements.push_back({&tree.treelet, nodes, references, leaves});
    nodes += tree.treelet.nodes.size(), references += tree.treelet.references.size(), leaves += tree.treelet.leaves;
  }
};

// A node of a treelet as the tree has it; `pairs` are the new places of the treelet's pairs.
KdNode placed(const KdNode& node, const TreeletPlacement& place, const std::vector<std::uint32_t>& pairs) {
  if (!node.is_leaf())
    return KdNode::inner(node.axis(), node.plane(),
                         static_cast<std::uint32_t>(2 * pairs[pair_of(node.lower_child())] + place.first_node));
  const std::uint32_t first = node.first_reference();
  return KdNode::leaf(first == kEmptyLeaf ? first : static_cast<std::uint32_t>(first + place.first_reference),
                      static_cast<std::uint32_t>(node.ordinal() + place.first_leaf));
}

// Writes the upper nodes, in the order in which TreeletLayout counted them.
void emit_upper(const KdSubtree& tree, std::uint64_t index, TreeletPlacement*& next_place, std::uint64_t& next_node,
                Buffer<KdNode>& nodes) {
  if (tree.is_treelet()) {
    TreeletPlacement& place = *next_place++;
    next_node += place.treelet->nodes.size();
    place.root = index;
    return;
  }
  const std::uint64_t pair = next_node;
  next_node += 2;
  nodes[index] = KdNode::inner(tree.axis, tree.position, static_cast<std::uint32_t>(pair));
  for (int c = 0; c < 2; ++c) emit_upper(*tree.child[c], pair + c, next_place, next_node, nodes);
}

void emit_treelet(const TreeletPlacement& place, KdTree& tree) {
  const KdTreelet& treelet = *place.treelet;
  const std::vector<std::uint32_t> pairs = clustered_pairs(treelet.nodes, treelet.root, treelet.cell, place.first_node / 2);
  KdNode* const nodes = tree.nodes.data() + place.first_node;
  for (std::size_t i = 0; i < treelet.nodes.size(); ++i)
    nodes[2 * pairs[i / 2] + i % 2] = placed(treelet.nodes[i], place, pairs);
  tree.nodes[place.root] = placed(treelet.root, place, pairs);
  std::copy(treelet.references.begin(), treelet.references.end(), tree.leaves.references.data() + place.first_reference);
}

// Gives slots to triangles in the order of their first references, and turns prim_ids into slots. Returns prim_ids by slot.
std::vector<std::uint32_t> number_triangles(BuildContext& context, std::span<std::uint32_t> references) {
  constexpr std::uint32_t kNoSlot = 0xffffffffu;
  std::vector<std::uint32_t> slots(context.mesh.size(), kNoSlot), prim_ids;
  prim_ids.reserve(context.report.triangles);
  context.memory.add((slots.size() + prim_ids.capacity()) * sizeof(std::uint32_t));
  for (std::uint32_t& reference : references) {
    std::uint32_t& slot = slots[slot_of(reference)];
    if (slot == kNoSlot) {
      slot = static_cast<std::uint32_t>(prim_ids.size());
      prim_ids.push_back(slot_of(reference));
    }
    reference = slot | (reference & kLastReference);
  }
  context.memory.subtract(slots.size() * sizeof(std::uint32_t));
  return prim_ids;
}

// Sorts the references of each leaf among themselves.
void sort_leaves(std::span<std::uint32_t> references) {
  for (std::size_t first = 0, i = 0; i < references.size(); ++i) {
    if (!is_last(references[i])) continue;
    references[i] = slot_of(references[i]);
    std::sort(references.begin() + first, references.begin() + i + 1);
    references[i] |= kLastReference;
    first = i + 1;
  }
}

}  // namespace

Result<KdTree> emit_kdtree(BuildContext& context, const KdSubtree& subtree) {
  context.begin_phase("emit");
  TreeletLayout layout;
  layout.visit(subtree);
  if (layout.nodes > kMaxKdNodes || layout.references >= kEmptyLeaf)
    return Error{"the kd-tree needs " + std::to_string(layout.nodes) + " nodes and " + std::to_string(layout.references) +
                 " references, more than its links can name; split the mesh, or lower max_references"};

  KdTree tree;
  tree.nodes = Buffer<KdNode>(layout.nodes);
  tree.leaves.references = Buffer<std::uint32_t>(layout.references);
  tree.leaf_count = static_cast<std::uint32_t>(layout.leaves);
  context.memory.add(tree.size_bytes());
  context.report.references = layout.references;

  TreeletPlacement* next_place = layout.placements.data();
  std::uint64_t next_node = 2;
  tree.nodes[1] = KdNode::leaf(kEmptyLeaf, 0);
  emit_upper(subtree, 0, next_place, next_node, tree.nodes);
  tbb::parallel_for(std::size_t{0}, layout.placements.size(), [&](std::size_t i) { emit_treelet(layout.placements[i], tree); });

  const std::vector<std::uint32_t> prim_ids = number_triangles(context, tree.leaves.references.span());
  tbb::parallel_for(std::size_t{0}, layout.placements.size(), [&](std::size_t i) {
    const TreeletPlacement& place = layout.placements[i];
    sort_leaves(tree.leaves.references.span().subspan(place.first_reference, place.treelet->references.size()));
  });
  tree.leaves.triangles = Buffer<PackedTriangle>(prim_ids.size());
  context.memory.add(tree.leaves.triangles.size_bytes());
  for_each_chunk(0, prim_ids.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t slot = begin; slot < end; ++slot)
      tree.leaves.triangles[slot] = pack(context.mesh.triangle(prim_ids[slot]), prim_ids[slot]);
  });
  return tree;
}

}  // namespace accel
