#include "libaccel/build/emit_bvh2.h"

#include <algorithm>

#include <tbb/parallel_for.h>

#include "libaccel/build/leaf_stream.h"

namespace accel {
namespace {

// Where a treelet's nodes and quads go.
struct Placement {
  Treelet* treelet;
  std::uint64_t first_node, first_quad;
};

// The final places of all subtrees, in depth-first order.
struct Layout {
  std::vector<Placement> placements;
  std::uint64_t nodes = 0, quads = 0, references = 0;

  void visit(Subtree& tree) {
    if (!tree.is_treelet()) {
      ++nodes;
      visit(*tree.child[0]), visit(*tree.child[1]);
      return;
    }
    placements.push_back({&tree.treelet, nodes, quads});
    nodes += tree.treelet.nodes.size(), quads += tree.treelet.quads;
    references += (tree.treelet.quads - tree.treelet.leaves.size()) / kQuadsPerTriangle;
  }
};

NodeRef placed(NodeRef ref, const Placement& place) {
  return is_leaf(ref) ? leaf_ref(static_cast<std::uint32_t>(leaf_quad(ref) + place.first_quad))
                      : static_cast<NodeRef>(ref + place.first_node);
}

// Writes the upper nodes, in the order in which Layout counted them. Returns the reference to `tree`.
NodeRef emit_upper(const Subtree& tree, const Placement*& next_place, std::uint64_t& next_node, Buffer<Bvh2Node>& nodes) {
  if (tree.is_treelet()) {
    const Placement& place = *next_place++;
    next_node += place.treelet->nodes.size();
    return placed(place.treelet->root, place);
  }
  const std::uint64_t index = next_node++;
  Bvh2Node node{};
  for (int c = 0; c < 2; ++c) {
    node.set_bounds(c, tree.bounds[c]);
    node.child[c] = emit_upper(*tree.child[c], next_place, next_node, nodes);
  }
  nodes[index] = node;
  return static_cast<NodeRef>(index);
}

// Moves a treelet's nodes and writes its leaves' triangles.
void emit_treelet(const BuildContext& context, const Placement& place, Reference* references, Bvh2& bvh) {
  const Treelet& treelet = *place.treelet;
  Bvh2Node* node = bvh.nodes.data() + place.first_node;
  for (const Bvh2Node& local : treelet.nodes) {
    *node = local;
    for (NodeRef& child : node->child) child = placed(child, place);
    ++node;
  }
  LeafQuad* quad = bvh.leaves.data() + place.first_quad;
  for (const LeafRun& leaf : treelet.leaves) {
    Reference* const first = references + leaf.begin;
    std::sort(first, first + leaf.count, [](const Reference& a, const Reference& b) { return a.prim_id < b.prim_id; });
    for (std::uint32_t i = 0; i < leaf.count; ++i) quad = write_triangle(context.mesh, first[i].prim_id, quad);
    quad = write_end_of_leaf(quad);
  }
}

}  // namespace

NodeRef Treelet::add_leaf(std::size_t begin, std::size_t count) {
  const NodeRef ref = leaf_ref(quads);
  leaves.push_back({static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(count)});
  quads += static_cast<std::uint32_t>(count) * kQuadsPerTriangle + 1;
  return ref;
}

Result<Bvh2> emit_bvh2(BuildContext& context, std::unique_ptr<Subtree> tree, Reference* references) {
  context.begin_phase("emit");
  Layout layout;
  layout.visit(*tree);
  if (layout.nodes >= kLeafBit || layout.quads >= kLeafBit - 1)
    return Error{"the structure needs " + std::to_string(layout.nodes) + " nodes and " + std::to_string(layout.quads) +
                 " leaf quads, more than the 31 bits of a reference can name; split the mesh or lower max_duplication"};

  Bvh2 bvh;
  bvh.nodes = Buffer<Bvh2Node>(layout.nodes);
  bvh.leaves = Buffer<LeafQuad>(layout.quads);
  bvh.references = layout.references;
  context.memory.add(bvh.size_bytes());
  context.report.references = layout.references;

  const Placement* next_place = layout.placements.data();
  std::uint64_t next_node = 0;
  bvh.root = emit_upper(*tree, next_place, next_node, bvh.nodes);
  tbb::parallel_for(std::size_t{0}, layout.placements.size(),
                    [&](std::size_t i) { emit_treelet(context, layout.placements[i], references, bvh); });
  for (const Placement& place : layout.placements) context.memory.subtract(place.treelet->size_bytes());
  return bvh;
}

}  // namespace accel
