#include "libaccel/structure/kdtree.h"

#include <cmath>
#include <string>
#include <vector>

namespace accel {
namespace {

std::string node_text(std::uint32_t index) { return "node " + std::to_string(index); }

Error count_error(const char* what, std::uint64_t found, std::uint64_t stated) {
  return Error{std::string("there are ") + std::to_string(found) + " " + what + ", but " + std::to_string(stated) +
               " are stated"};
}

bool is_finite(Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
bool same_corners(const Aabb& a, const Aabb& b) { return a.lo == b.lo && a.hi == b.hi; }

// Follows all nodes from the root, with their cells. Iterative: a hostile file may be a chain of a billion nodes.
class KdTreeWalk {
 public:
  explicit KdTreeWalk(const KdTree& tree)
      : tree_(tree),
        owned_(tree.nodes.size() / 2),
        named_(tree.leaves.references.size()),
        numbered_(tree.leaf_count),
        cells_(tree.ropes.empty() ? 0 : tree.nodes.size()),
        leaf_cells_(cells_.empty() ? 0 : tree.leaf_count) {}

  Status run() {
    owned_[pair_of(kKdRoot)] = true;
    pending_.push_back({kKdRoot, 0, tree_.bounds});
    while (!pending_.empty()) {
      const Visit next = pending_.back();
      pending_.pop_back();
      if (!cells_.empty()) cells_[next.index] = next.cell;
      Status status = tree_.nodes[next.index].is_leaf() ? visit_leaf(next) : visit_inner(next);
      if (!status) return status;
    }
    if (pairs_ != owned_.size())
      return Error{"the root reaches " + std::to_string(pairs_) + " pairs of nodes, but there are " +
                   std::to_string(owned_.size())};
    if (leaves_ != tree_.leaf_count) return count_error("leaves", leaves_, tree_.leaf_count);
    if (depth_ != tree_.depth)
      return Error{"the longest path has " + std::to_string(depth_) + " nodes, but depth is " + std::to_string(tree_.depth)};
    return check_runs();
  }

  // After run(): the ropes of all leaves. A rope's subtree touches the face and covers it, so that whoever leaves the leaf
  // there is in the subtree's cell.
  Status check_ropes() const {
    for (std::uint32_t ordinal = 0; ordinal < tree_.ropes.size(); ++ordinal)
      for (int face = 0; face < 6; ++face)
        if (!is_good_rope(tree_.ropes[ordinal], leaf_cells_[ordinal], face))
          return Error{"leaf " + std::to_string(ordinal) + " has a cell or ropes that are not its own"};
    return Done{};
  }

 private:
  struct Visit {
    std::uint32_t index, above;  // inner nodes on the path so far
    Aabb cell;
  };

  Status visit_leaf(const Visit& leaf) {
    const KdNode node = tree_.nodes[leaf.index];
    if (node.ordinal() >= numbered_.size() || numbered_[node.ordinal()])
      return Error{node_text(leaf.index) + " is leaf " + std::to_string(node.ordinal()) + ", as another is or beyond the " +
                   std::to_string(tree_.leaf_count) + " that are stated"};
    numbered_[node.ordinal()] = true, ++leaves_;
    if (!leaf_cells_.empty()) leaf_cells_[node.ordinal()] = leaf.cell;
    depth_ = leaf.above > depth_ ? leaf.above : depth_;

    const std::uint32_t first = node.first_reference();
    if (first == kEmptyLeaf) return Done{};
    const bool is_run = first < named_.size() && (first == 0 || is_last(tree_.leaves.references[first - 1]));
    if (!is_run || named_[first])
      return Error{node_text(leaf.index) + " names reference " + std::to_string(first) +
                   ", where no leaf starts or that another leaf names"};
    named_[first] = true;
    return Done{};
  }

  Status visit_inner(const Visit& inner) {
    const KdNode node = tree_.nodes[inner.index];
    const std::uint32_t child = node.lower_child(), pair = pair_of(child);
    if (child % 2 != 0 || child <= inner.index || pair >= owned_.size())
      return Error{node_text(inner.index) + " has children at " + std::to_string(child) +
                   ", which is no pair of nodes behind it"};
    if (owned_[pair]) return Error{node_text(child) + " is the child of more than one node"};
    owned_[pair] = true, ++pairs_;
    const int axis = node.axis();
    if (!(node.plane() > inner.cell.lo[axis]) || !(node.plane() < inner.cell.hi[axis]))
      return Error{node_text(inner.index) + " has a plane that is not strictly within its cell"};
    if (!tree_.parents.empty() && tree_.parents[pair] != inner.index)
      return Error{node_text(inner.index) + " is not the parent that its children state"};
    if (!tree_.cells.empty() && !same_corners(tree_.cells[pair], inner.cell))
      return Error{node_text(inner.index) + " has another cell than its children state"};

    Visit children[2] = {{child, inner.above + 1, inner.cell}, {child + 1, inner.above + 1, inner.cell}};
    children[0].cell.hi[axis] = children[1].cell.lo[axis] = node.plane();
    pending_.push_back(children[1]), pending_.push_back(children[0]);
    return Done{};
  }

  // Each run of references belongs to a leaf.
  Status check_runs() const {
    for (std::size_t i = 0; i < named_.size(); ++i)
      if ((i == 0 || is_last(tree_.leaves.references[i - 1])) && !named_[i])
        return Error{"the references from " + std::to_string(i) + " on belong to no leaf"};
    return Done{};
  }

  bool is_good_rope(const LeafRopes& ropes, const Aabb& cell, int face) const {
    if (!same_corners(ropes.cell, cell)) return false;
    const int axis = face % 3;
    const bool is_upper = face >= 3;
    const float border = is_upper ? tree_.bounds.hi[axis] : tree_.bounds.lo[axis];
    const float plane = is_upper ? cell.hi[axis] : cell.lo[axis];
    const std::uint32_t rope = ropes.rope[face];
    if (plane == border) return rope == kNoRope;
    if (rope >= cells_.size() || rope == pair_of(kKdRoot) + 1) return false;
    const Aabb& behind = cells_[rope];
    if ((is_upper ? behind.lo[axis] : behind.hi[axis]) != plane) return false;
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    return behind.lo[b] <= cell.lo[b] && behind.hi[b] >= cell.hi[b] && behind.lo[c] <= cell.lo[c] && behind.hi[c] >= cell.hi[c];
  }

  const KdTree& tree_;
  std::vector<bool> owned_;     // by pair
  std::vector<bool> named_;     // by reference: a leaf starts here
  std::vector<bool> numbered_;  // by ordinal
  std::vector<Aabb> cells_;     // by node, where there are ropes
  std::vector<Aabb> leaf_cells_;
  std::vector<Visit> pending_;
  std::uint64_t pairs_ = 1, leaves_ = 0;  // reached
  std::uint32_t depth_ = 0;
};

Status check_empty(const KdTree& tree) {
  if (bytes_of_arrays(tree) == 0 && tree.depth == 0 && tree.leaf_count == 0) return Done{};
  return Error{"there are no nodes, but there are leaves"};
}

Status check_sizes(const KdTree& tree) {
  const std::size_t nodes = tree.nodes.size(), pairs = nodes / 2;
  if (nodes % 2 != 0 || nodes > kMaxKdNodes) return Error{std::to_string(nodes) + " nodes are odd or too many"};
  if (tree.leaf_count > nodes) return count_error("nodes", nodes, tree.leaf_count);
  if (tree.parents.size() != tree.cells.size() || (!tree.parents.empty() && tree.parents.size() != pairs))
    return Error{"parents and cells are not one for each pair of nodes"};
  if (!tree.ropes.empty() && tree.ropes.size() != tree.leaf_count) return Error{"ropes are not one for each leaf"};
  const Aabb& box = tree.bounds;
  if (!is_finite(box.lo) || !is_finite(box.hi) || !(box.lo.x < box.hi.x && box.lo.y < box.hi.y && box.lo.z < box.hi.z))
    return Error{"the box of the whole tree is not finite, or flat"};
  return Done{};
}

}  // namespace

Status validate(const KdTree& tree, std::uint64_t triangle_count) {
  if (tree.nodes.empty()) return check_empty(tree);
  if (Status status = check_sizes(tree); !status) return status;
  if (Status status = validate(tree.leaves, triangle_count); !status) return status;
  KdTreeWalk walk(tree);
  if (Status status = walk.run(); !status) return status;
  return walk.check_ropes();
}

}  // namespace accel
