// Visits all nodes and leaves of a Bvh2 from the root down, with what their place in the tree implies: relatives and key.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "libaccel/structure/bvh2.h"

namespace accel {

// A node or a leaf; kNoNode for relatives that it does not have.
struct Bvh2Place {
  NodeRef ref = kNoNode;
  NodeRef parent = kNoNode;
  NodeRef sibling = kNoNode, uncle = kNoNode, grand_uncle = kNoNode, great_grand_uncle = kNoNode;
  NodeKey key;

  // Of an inner node. `multiplier` is the hash's.
  Bvh2Place child(const Bvh2View& view, std::uint32_t side, std::uint64_t multiplier) const {
    const NodeRef* const children = view.nodes[ref].child;
    return {children[side], ref, children[side ^ 1u], sibling, uncle, grand_uncle, key.child(side, multiplier)};
  }
};

// Below one place, iteratively: a tree from a file may be as deep as it has nodes. visit(place) returns whether to go on; so
// does the walk.
template <class Visit>
bool walk_bvh2(const Bvh2View& view, const Bvh2Place& from, std::uint64_t multiplier, const Visit& visit) {
  std::vector<Bvh2Place> pending{from};
  while (!pending.empty()) {
    const Bvh2Place place = pending.back();
    pending.pop_back();
    if (!visit(place)) return false;
    if (is_leaf(place.ref)) continue;
    for (const std::uint32_t side : {1u, 0u}) pending.push_back(place.child(view, side, multiplier));
  }
  return true;
}

// Where the words of a leaf are.
inline std::uint32_t terminator_of(const LeafQuad* leaves, NodeRef leaf) {
  std::uint32_t quad = leaf_quad(leaf);
  while (!is_end_of_leaf(leaves, quad)) quad += kQuadsPerTriangle;
  return quad;
}

// The links that a place implies, in the order of node padding and terminators.
struct PlaceLinks {
  NodeRef link[3];
};
inline PlaceLinks links_of(const Bvh2Place& place, Bvh2Links kind) {
  if (kind == Bvh2Links::parents) return {{place.parent, place.sibling, 0}};
  if (kind == Bvh2Links::uncles) return {{place.uncle, place.grand_uncle, place.great_grand_uncle}};
  return {{0, 0, 0}};
}

}  // namespace accel
