#include "libaccel/build/collapse_wide.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "libaccel/build/parallel.h"
#include "libaccel/build/wide_forests.h"
#include "libaccel/build/wide_node.h"

namespace accel {
namespace {

std::uint32_t blocks_for(std::uint32_t triangles) { return (triangles + kBlockLanes - 1) / kBlockLanes; }

// A subtree of the binary tree that becomes a child.
struct Child {
  NodeRef ref;
  Aabb box;
  bool as_leaf;
};

struct Family {
  Child child[kBvh8Arity];
  std::uint32_t count = 0;
};

// Of a leaf's triangles, those that make a block.
struct BlockRun {
  std::size_t first;
  std::uint32_t count;
};

class Collapse {
 public:
  Collapse(const Bvh2& bvh, const BuildOptions& options) : bvh_(bvh), options_(options), forests_(bvh.nodes.size()) {}

  Result<Bvh8> run() {
    Bvh8 wide;
    if (bvh_.root == kNoNode) return wide;
    choose();
    if (Status s = lay_out(wide); !s) return s.error();
    write_blocks(wide);
    return wide;
  }

 private:
  // ---- costs, from the leaves up
  void choose() {
    const std::vector<NodeRef> order = parents_first();
    std::vector<std::uint32_t> triangles(bvh_.nodes.size());
    const auto size_of = [&](NodeRef ref) { return is_leaf(ref) ? leaf_size(ref) : triangles[ref]; };
    const double root_area = half_area_in_double(bvh_.bounds), scale = root_area > 0 ? 1 / root_area : 0;
    for (auto at = order.rbegin(); at != order.rend(); ++at) {
      const Bvh2Node& node = bvh_.nodes[*at];
      Aabb box = node.bounds(0);
      box.extend(node.bounds(1));
      const std::uint32_t size[2] = {size_of(node.child[0]), size_of(node.child[1])};
      const auto forests_of = [&](int c) {
        if (!is_leaf(node.child[c])) return forests_[node.child[c]];
        return WideForests(leaf_cost(static_cast<float>(half_area_in_double(node.bounds(c)) * scale), size[c]));
      };
      const auto area = static_cast<float>(half_area_in_double(box) * scale);
      const std::uint32_t sum = triangles[*at] = size[0] + size[1];
      const bool fits = sum <= static_cast<std::uint32_t>(options_.max_leaf_size);
      forests_[*at].choose(forests_of(0), forests_of(1), area * options_.traversal_cost,
                           fits ? leaf_cost(area, sum) : std::numeric_limits<float>::infinity());
    }
  }

  float leaf_cost(float area, std::uint32_t triangles) const {
    return area * options_.intersection_cost * static_cast<float>(blocks_for(triangles));
  }

  std::vector<NodeRef> parents_first() const {
    std::vector<NodeRef> order, pending{bvh_.root};
    order.reserve(bvh_.nodes.size());
    while (!pending.empty()) {
      const NodeRef ref = pending.back();
      pending.pop_back();
      if (is_leaf(ref)) continue;
      order.push_back(ref);
      pending.push_back(bvh_.nodes[ref].child[1]), pending.push_back(bvh_.nodes[ref].child[0]);
    }
    return order;
  }

  std::uint32_t leaf_size(NodeRef leaf) const {
    std::uint32_t quad = leaf_quad(leaf), size = 0;
    for (; !is_end_of_leaf(bvh_.leaves.data(), quad); quad += kQuadsPerTriangle) ++size;
    return size;
  }

  // ---- which subtrees become children, and where
  struct Pending {
    NodeRef ref;  // of the binary tree
    std::uint32_t wide, above;
  };

  Status lay_out(Bvh8& wide) {
    static_cast<Bvh8Words&>(wide) = {kNoNode, 0, 0, bvh_.bounds};
    wide.root = place({bvh_.root, bvh_.bounds, is_leaf(bvh_.root) || forests_[bvh_.root].is_leaf()}, 0);
    while (!pending_.empty()) {
      const Pending next = pending_.back();
      pending_.pop_back();
      wide.depth = std::max(wide.depth, next.above + 1);
      make_node(next);
    }
    if (nodes_.size() >= kLeafBit || blocks_.size() > kMaxBlocks)
      return Error{"the wide tree needs " + std::to_string(nodes_.size()) + " nodes and " + std::to_string(blocks_.size()) +
                   " blocks of triangles, more than a reference can name; split the mesh or lower max_duplication"};
    wide.nodes = Buffer<Bvh8Node>::copy_of(nodes_);
    wide.references = quads_.size();
    return Done{};
  }

  void make_node(const Pending& at) {
    Family family;
    int roots = static_cast<int>(kBvh8Arity);
    const int left = forests_[at.ref].left(roots);
    const Bvh2Node& binary = bvh_.nodes[at.ref];
    gather(binary.child[0], binary.bounds(0), left, family);
    gather(binary.child[1], binary.bounds(1), roots - left, family);

    WideChild children[kBvh8Arity];
    const std::size_t first_pending = pending_.size();
    for (std::uint32_t c = 0; c < family.count; ++c)
      children[c] = {place(family.child[c], at.above + 1), Box4::of(family.child[c].box)};
    std::reverse(pending_.begin() + static_cast<std::ptrdiff_t>(first_pending), pending_.end());  // the first comes next
    make_wide_node(children, family.count, nodes_[at.wide]);
  }

  // At most eight roots deep.
  void gather(NodeRef ref, const Aabb& box, int roots, Family& family) const {
    if (is_leaf(ref)) {
      family.child[family.count++] = {ref, box, true};
      return;
    }
    const int left = forests_[ref].left(roots);
    if (roots == 1) {
      family.child[family.count++] = {ref, box, forests_[ref].is_leaf()};
      return;
    }
    const Bvh2Node& node = bvh_.nodes[ref];
    gather(node.child[0], node.bounds(0), left, family);
    gather(node.child[1], node.bounds(1), roots - left, family);
  }

  // Makes room for a child, and a leaf at once. Returns its reference.
  NodeRef place(const Child& child, std::uint32_t above) {
    if (child.as_leaf) return make_leaf(child.ref);
    pending_.push_back({child.ref, static_cast<std::uint32_t>(nodes_.size()), above});
    nodes_.emplace_back();
    return pending_.back().wide;
  }

  NodeRef make_leaf(NodeRef ref) {
    const std::size_t first = quads_.size();
    gather_quads(ref);
    const auto prim_id = [&](std::uint32_t quad) { return bvh_.leaves[quad].word; };
    const auto begin = quads_.begin() + static_cast<std::ptrdiff_t>(first);
    std::sort(begin, quads_.end(), [&](auto a, auto b) { return prim_id(a) < prim_id(b); });
    quads_.erase(std::unique(begin, quads_.end(), [&](auto a, auto b) { return prim_id(a) == prim_id(b); }), quads_.end());

    const auto count = static_cast<std::uint32_t>(quads_.size() - first);
    const std::uint32_t blocks = blocks_for(count);
    const NodeRef leaf = block_ref(static_cast<std::uint32_t>(blocks_.size()) & (kMaxBlocks - 1), blocks);
    for (std::uint32_t b = 0; b < blocks; ++b)
      blocks_.push_back({first + std::size_t{b} * kBlockLanes, std::min(count - b * kBlockLanes, kBlockLanes)});
    if (blocks > kMostCounted) blocks_.push_back({quads_.size(), 0});
    return leaf;
  }

  // The triangles below a binary node.
  void gather_quads(NodeRef root) {
    below_.assign(1, root);
    while (!below_.empty()) {
      const NodeRef ref = below_.back();
      below_.pop_back();
      if (is_leaf(ref)) {
        for (std::uint32_t quad = leaf_quad(ref); !is_end_of_leaf(bvh_.leaves.data(), quad); quad += kQuadsPerTriangle)
          quads_.push_back(quad);
      } else {
        below_.push_back(bvh_.nodes[ref].child[1]), below_.push_back(bvh_.nodes[ref].child[0]);
      }
    }
  }

  // ---- triangles
  void write_blocks(Bvh8& wide) const {
    wide.blocks = Buffer<TriangleBlock>(blocks_.size());
    for_chunks(0, blocks_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b)
        for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane)
          if (lane < blocks_[b].count)
            wide.blocks[b].set(lane, packed_triangle(bvh_.leaves.data(), quads_[blocks_[b].first + lane]));
          else
            wide.blocks[b].clear(lane);
    });
  }

  const Bvh2& bvh_;
  const BuildOptions& options_;
  std::vector<WideForests> forests_;
  std::vector<Bvh8Node> nodes_;
  std::vector<Pending> pending_;
  std::vector<NodeRef> below_;
  std::vector<std::uint32_t> quads_;  // where the triangles of all leaves are in the binary tree
  std::vector<BlockRun> blocks_;      // of quads_
};

}  // namespace

Result<Bvh8> collapse_wide(const Bvh2& bvh, const BuildOptions& options) { return Collapse(bvh, options).run(); }

std::uint64_t collapse_peak_bytes(const Bvh2& bvh, const Bvh8& wide) {
  const std::uint64_t forests = bvh.nodes.size() * sizeof(WideForests), nodes = wide.nodes.size_bytes();
  const std::uint64_t runs = wide.references * sizeof(std::uint32_t) + wide.blocks.size() * sizeof(BlockRun);
  return bvh.size_bytes() + wide.size_bytes() + forests + nodes + runs;
}

}  // namespace accel
