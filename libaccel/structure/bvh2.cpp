#include "libaccel/structure/bvh2.h"

#include <algorithm>
#include <bit>
#include <string>
#include <vector>

#include "libaccel/structure/bvh2_annotations.h"
#include "libaccel/structure/leaf_scan.h"

namespace accel {
namespace {

// Whether the box has lo <= hi; NaN has not.
bool is_ordered(const Aabb& box) { return !box.empty(); }

// Follows all references from the root, each once. Iterative: a hostile file may be a chain of a hundred million nodes.
class Bvh2Walk {
 public:
  Bvh2Walk(const Bvh2& bvh, LeafScan& scan) : bvh_(bvh), scan_(scan), seen_(bvh.nodes.size()) {}

  Status run() {
    pending_.push_back({bvh_.root, 0});
    while (!pending_.empty()) {
      const Pending next = pending_.back();
      pending_.pop_back();
      Status status = is_leaf(next.ref) ? visit_leaf(next) : visit_node(next);
      if (!status) return status;
    }
    if (nodes_ != bvh_.nodes.size())
      return Error{"the root reaches " + std::to_string(nodes_) + " nodes, but there are " + std::to_string(bvh_.nodes.size())};
    if (leaves_ != scan_.leaves)
      return Error{"the root reaches " + std::to_string(leaves_) + " leaves, but there are " + std::to_string(scan_.leaves)};
    if (depth_ != bvh_.depth)
      return Error{"the longest path has " + std::to_string(depth_) + " nodes, but depth is " + std::to_string(bvh_.depth)};
    return Done{};
  }

 private:
  struct Pending {
    NodeRef ref;
    std::uint32_t above;  // inner nodes on the path so far
  };

  Status visit_leaf(const Pending& leaf) {
    const std::uint32_t quad = leaf_quad(leaf.ref);
    if (quad >= scan_.is_start.size() || !scan_.is_start[quad])
      return Error{"a child reference names quad " + std::to_string(quad) +
                   ", where no leaf starts or that another child names"};
    scan_.is_start[quad] = false, ++leaves_;
    depth_ = std::max(depth_, leaf.above);
    return Done{};
  }

  Status visit_node(const Pending& inner) {
    if (inner.ref >= seen_.size())
      return Error{"a child reference names node " + std::to_string(inner.ref) + ", but there are " +
                   std::to_string(seen_.size())};
    if (seen_[inner.ref])
      return Error{"node " + std::to_string(inner.ref) + " is the child of more than one node, or the root"};
    seen_[inner.ref] = true, ++nodes_;
    const Bvh2Node& node = bvh_.nodes[inner.ref];
    for (int c = 0; c < 2; ++c) {
      if (!is_ordered(node.bounds(c)))
        return Error{"node " + std::to_string(inner.ref) + " has a box for child " + std::to_string(c) +
                     " that is inverted or NaN"};
      pending_.push_back({node.child[c], inner.above + 1});
    }
    return Done{};
  }

  const Bvh2& bvh_;
  LeafScan& scan_;
  std::vector<bool> seen_;
  std::vector<Pending> pending_;
  std::uint64_t nodes_ = 0, leaves_ = 0;
  std::uint32_t depth_ = 0;
};

}  // namespace

bool Bvh2::has(Bvh2Extras extras) const {
  if (root == kNoNode) return true;
  switch (extras) {
    case Bvh2Extras::parents:
      return links == Bvh2Links::parents;
    case Bvh2Extras::uncles:
      return links == Bvh2Links::uncles;
    case Bvh2Extras::hash:
      return hashed != HashedKeys::none;
    case Bvh2Extras::full_hash:
      return hashed == HashedKeys::all;
    case Bvh2Extras::skips:
      return nodes.empty() || !skips.empty();
    case Bvh2Extras::octant_skips:
      return nodes.empty() || !octant_skips.empty();
    case Bvh2Extras::octo:
      return nodes.empty() || !octo.empty();
  }
  return false;
}

Bvh2View Bvh2::view() const {
  Bvh2View view{nodes.data(), leaves.data(), root, depth};
  view.skips = skips.data(), view.octant_skips = octant_skips.data();
  view.node_count = static_cast<std::uint32_t>(nodes.size());
  view.octo = octo.data(), view.octo_count = static_cast<std::uint32_t>(octo.size());
  view.bounds = bounds;
  view.hash.multiplier = hash_multiplier;
  if (displacements.empty()) return view;
  view.hash.displacements = displacements.data(), view.hash.slots = slots.data();
  view.hash.slot_count = static_cast<std::uint32_t>(slots.size());
  view.hash.log2_of_buckets = static_cast<std::uint32_t>(std::countr_zero(displacements.size()));
  view.hash.reciprocal = has_narrow_keys() ? reciprocal_of<std::uint32_t>(view.hash.slot_count)
                                           : reciprocal_of<std::uint64_t>(view.hash.slot_count);
  return view;
}

Status validate(const Bvh2& bvh, std::uint64_t triangle_count) {
  if (bvh.nodes.size() >= kLeafBit || bvh.leaves.size() >= kLeafBit)
    return Error{"more nodes or leaf quads than the 31 bits of a reference can name"};
  Result<LeafScan> scan = scan_leaves(bvh.leaves.span(), triangle_count);
  if (!scan) return scan.error();
  if (scan->references != bvh.references)
    return Error{"the leaves hold " + std::to_string(scan->references) + " triangles, but references is " +
                 std::to_string(bvh.references)};
  if (bvh.root == kNoNode) {
    if (bytes_of_arrays(bvh) == 0 && bvh.depth == 0) return Done{};
    return Error{"there is no root, but there are nodes or leaves"};
  }
  if (!is_ordered(bvh.bounds)) return Error{"the box of the whole tree is inverted or NaN"};
  if (Status status = Bvh2Walk(bvh, *scan).run(); !status) return status;
  return check_annotations(bvh);
}

}  // namespace accel
