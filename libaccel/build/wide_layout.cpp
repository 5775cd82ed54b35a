#include "libaccel/build/wide_layout.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

#include "libaccel/build/wide_node.h"

namespace accel {
namespace {

// Levels of the wide tree that are cut into pieces: some hundred tasks.
constexpr int kCutLevels = 3;

// A subtree of the binary tree that becomes a child.
struct SubtreeChild {
  NodeRef ref;
  Aabb box;
  bool as_leaf;
};

struct SubtreeFamily {
  SubtreeChild child[kBvh8Arity];
  std::uint32_t count = 0;
};

// Of a leaf's triangles, those that make a block.
struct TriangleRun {
  std::size_t first;
  std::uint32_t count;
};

// A wide node and all that is below it. References are relative to the piece's first node, which is the first inner child, and
// to its first block.
struct Piece {
  Bvh8Node root;
  std::vector<Bvh8Node> nodes;       // below the root; none where it is cut
  std::vector<std::uint32_t> quads;  // where the leaves' triangles are in the binary tree
  std::vector<TriangleRun> runs;     // of quads
  std::vector<Piece> cut;            // of the inner children

  std::uint32_t depth = 0;                                   // inner nodes on the longest path, the root included
  std::size_t all_nodes = 0, all_blocks = 0, all_quads = 0;  // those of `cut` too

  void sum_up() {
    all_nodes = nodes.size() + cut.size(), all_blocks = runs.size(), all_quads = quads.size();
    for (const Piece& part : cut) {
      depth = std::max(depth, part.depth + 1);
      all_nodes += part.all_nodes, all_blocks += part.all_blocks, all_quads += part.all_quads;
    }
  }
};

class PieceMaker {
 public:
  PieceMaker(const Bvh2& bvh, const Buffer<WideForests>& forests) : bvh_(bvh), forests_(forests) {}

  Piece make(NodeRef root, int level) const {
    Piece piece;
    std::vector<Pending> inner;
    piece.root = make_node(piece, root, 0, inner);
    piece.depth = 1;
    if (level < kCutLevels) {
      piece.cut.resize(inner.size());
      tbb::parallel_for(std::size_t{0}, inner.size(), [&](std::size_t i) { piece.cut[i] = make(inner[i].ref, level + 1); });
    } else {
      make_all_below(piece, std::move(inner));
    }
    piece.sum_up();
    return piece;
  }

  // The triangles below a binary node, each once. Returns the reference.
  NodeRef make_leaf(Piece& piece, NodeRef ref) const {
    std::vector<std::uint32_t>& quads = piece.quads;
    const std::size_t first = quads.size();
    gather_quads(ref, quads);
    const auto prim_id = [&](std::uint32_t quad) { return bvh_.leaves[quad].word; };
    const auto begin = quads.begin() + static_cast<std::ptrdiff_t>(first);
    std::sort(begin, quads.end(), [&](auto a, auto b) { return prim_id(a) < prim_id(b); });
    quads.erase(std::unique(begin, quads.end(), [&](auto a, auto b) { return prim_id(a) == prim_id(b); }), quads.end());

    const auto count = static_cast<std::uint32_t>(quads.size() - first);
    const std::uint32_t blocks = blocks_for(count);
    const NodeRef leaf = block_ref(static_cast<std::uint32_t>(piece.runs.size()) & (kMaxBlocks - 1), blocks);
    for (std::uint32_t b = 0; b < blocks; ++b)
      piece.runs.push_back({first + std::size_t{b} * kBlockLanes, std::min(count - b * kBlockLanes, kBlockLanes)});
    if (blocks > kMostCounted) piece.runs.push_back({quads.size(), 0});
    return leaf;
  }

  bool is_leaf_of_wide(NodeRef ref) const { return is_leaf(ref) || forests_[ref].is_leaf(); }

 private:
  struct Pending {
    NodeRef ref;           // of the binary tree
    std::uint32_t node;    // of the piece
    std::uint32_t levels;  // above it, the root included
  };

  // Nothing here recurses by the depth of the tree.
  void make_all_below(Piece& piece, std::vector<Pending> pending) const {
    piece.nodes.resize(pending.size());
    std::reverse(pending.begin(), pending.end());
    std::vector<Pending> inner;
    while (!pending.empty()) {
      const Pending next = pending.back();
      pending.pop_back();
      piece.depth = std::max(piece.depth, next.levels + 1);
      inner.clear();
      const Bvh8Node node = make_node(piece, next.ref, next.levels, inner);
      piece.nodes[next.node] = node;
      piece.nodes.resize(piece.nodes.size() + inner.size());
      pending.insert(pending.end(), inner.rbegin(), inner.rend());  // the first comes next
    }
  }

  // A node, with its leaves; the inner children go behind the piece's nodes, where the caller makes room.
  Bvh8Node make_node(Piece& piece, NodeRef ref, std::uint32_t levels, std::vector<Pending>& inner) const {
    const SubtreeFamily family = family_of(ref);
    WideChild children[kBvh8Arity];
    for (std::uint32_t c = 0; c < family.count; ++c) {
      const SubtreeChild& child = family.child[c];
      const auto next = static_cast<std::uint32_t>(piece.nodes.size() + inner.size());
      children[c] = {child.as_leaf ? make_leaf(piece, child.ref) : next, Box4::of(child.box)};
      if (!child.as_leaf) inner.push_back({child.ref, next, levels + 1});
    }
    Bvh8Node node;
    make_wide_node(children, family.count, node);
    return node;
  }

  SubtreeFamily family_of(NodeRef ref) const {
    SubtreeFamily family;
    int roots = static_cast<int>(kBvh8Arity);
    const int left = forests_[ref].left(roots);
    const Bvh2Node& node = bvh_.nodes[ref];
    gather(node.child[0], node.bounds(0), left, family);
    gather(node.child[1], node.bounds(1), roots - left, family);
    return family;
  }

  // At most eight roots deep.
  void gather(NodeRef ref, const Aabb& box, int roots, SubtreeFamily& family) const {
    const int left = is_leaf(ref) ? 0 : forests_[ref].left(roots);
    if (is_leaf(ref) || roots == 1) {
      family.child[family.count++] = {ref, box, is_leaf_of_wide(ref)};
      return;
    }
    const Bvh2Node& node = bvh_.nodes[ref];
    gather(node.child[0], node.bounds(0), left, family);
    gather(node.child[1], node.bounds(1), roots - left, family);
  }

  void gather_quads(NodeRef root, std::vector<std::uint32_t>& quads) const {
    std::vector<NodeRef> below{root};
    while (!below.empty()) {
      const NodeRef ref = below.back();
      below.pop_back();
      if (is_leaf(ref)) {
        for (std::uint32_t quad = leaf_quad(ref); !is_end_of_leaf(bvh_.leaves.data(), quad); quad += kQuadsPerTriangle)
          quads.push_back(quad);
      } else {
        below.push_back(bvh_.nodes[ref].child[1]), below.push_back(bvh_.nodes[ref].child[0]);
      }
    }
  }

  const Bvh2& bvh_;
  const Buffer<WideForests>& forests_;
};

// Where the first node and the first block of a piece are.
struct Place {
  std::size_t node, block;

  void move(Bvh8Node& node_there) const {
    for (NodeRef& child : node_there.child)
      if (child != kNoNode) child += static_cast<std::uint32_t>(is_leaf(child) ? block : node);
  }
};

class PieceWriter {
 public:
  PieceWriter(const Bvh2& bvh, Bvh8& wide) : bvh_(bvh), wide_(wide) {}

  void write(const Piece& piece, std::size_t root, Place at) const {
    wide_.nodes[root] = piece.root;
    at.move(wide_.nodes[root]);
    for (std::size_t i = 0; i < piece.nodes.size(); ++i) {
      wide_.nodes[at.node + i] = piece.nodes[i];
      at.move(wide_.nodes[at.node + i]);
    }
    write_blocks(piece, at.block);

    std::vector<Place> places;
    Place next{at.node + piece.cut.size(), at.block + piece.runs.size()};
    for (const Piece& part : piece.cut) {
      places.push_back(next);
      next.node += part.all_nodes, next.block += part.all_blocks;
    }
    tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) { write(piece.cut[i], at.node + i, places[i]); });
  }

  void write_blocks(const Piece& piece, std::size_t first) const {
    for (const TriangleRun& run : piece.runs) {
      TriangleBlock& block = wide_.blocks[first++];
      for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane)
        if (lane < run.count)
          block.set(lane, packed_triangle(bvh_.leaves.data(), piece.quads[run.first + lane]));
        else
          block.clear(lane);
    }
  }

 private:
  const Bvh2& bvh_;
  Bvh8& wide_;
};

}  // namespace

Result<Bvh8> lay_out_wide(const Bvh2& bvh, const Buffer<WideForests>& forests) {
  const PieceMaker maker(bvh, forests);
  const bool has_nodes = !maker.is_leaf_of_wide(bvh.root);
  Piece all;
  NodeRef root = 0;
  if (has_nodes) {
    all = maker.make(bvh.root, 0);
  } else {
    root = maker.make_leaf(all, bvh.root);
    all.sum_up();
  }
  const std::size_t nodes = all.all_nodes + (has_nodes ? 1 : 0);
  if (nodes >= kLeafBit || all.all_blocks > kMaxBlocks)
    return Error{"the wide tree needs " + std::to_string(nodes) + " nodes and " + std::to_string(all.all_blocks) +
                 " blocks of triangles, more than a reference can name; split the mesh or lower max_duplication"};

  Bvh8 wide;
  static_cast<Bvh8Words&>(wide) = {root, all.depth, all.all_quads, bvh.bounds};
  wide.nodes = Buffer<Bvh8Node>(nodes);
  wide.blocks = Buffer<TriangleBlock>(all.all_blocks);
  const PieceWriter writer(bvh, wide);
  if (has_nodes)
    writer.write(all, 0, {1, 0});
  else
    writer.write_blocks(all, 0);
  return wide;
}

std::uint64_t wide_layout_peak_bytes(const Bvh8& wide) {
  const std::uint64_t runs = wide.references * sizeof(std::uint32_t) + wide.blocks.size() * sizeof(TriangleRun);
  return wide.size_bytes() + wide.nodes.size_bytes() + runs;
}

}  // namespace accel
