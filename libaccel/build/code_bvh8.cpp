#include "libaccel/build/code_bvh8.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "libaccel/build/index_blocks.h"
#include "libaccel/build/parallel.h"

namespace accel {
namespace {

// Sets one axis of the frame for planes from `lo` to `hi`.
template <class Node>
void set_frame(Node& node, int axis, float lo, float hi) {
  node.origin[axis] = lo;
  const double size = static_cast<double>(hi) - lo, most = Node::Coding::value(Node::Coding::kMost);
  int exponent = size > 0 ? std::ilogb(size / most) : Node::kLeastExponent;
  exponent = std::clamp(exponent, Node::kLeastExponent, Node::kMostExponent);
  node.exponent[axis] = static_cast<std::int8_t>(exponent);
  while (node.decode(axis, Node::Coding::kMost) < hi) ++node.exponent[axis];  // once at most, but for the sum's rounding
}

// A code whose plane is at most `plane` (side 0) or at least that (side 1), and the next best to it. A sum that is exactly on
// the right side of a float is there when it is rounded, too: the loops take a step or two.
template <class Node>
typename Node::Code code_of(const Node& node, int axis, int side, float plane) {
  using Coding = typename Node::Coding;
  const double steps = (static_cast<double>(plane) - node.origin[axis]) / node.scale(axis);
  auto code = Coding::near(std::clamp(steps, 0.0, static_cast<double>(Coding::value(Coding::kMost))));
  if (side == 0)
    while (node.decode(axis, code) > plane) code = Coding::previous(code);
  else
    while (node.decode(axis, code) < plane) code = Coding::next(code);
  return code;
}

template <class Node>
Node coded(const Bvh8Node& from) {
  Node node{};
  std::copy(std::begin(from.child), std::end(from.child), node.child);
  std::copy(std::begin(from.order), std::end(from.order), node.order);
  Aabb all;
  std::uint32_t children = 0;
  while (children < kBvh8Arity && from.child[children] != kNoNode) all.extend(from.bounds(children++));
  for (int a = 0; a < 3; ++a) {
    set_frame(node, a, all.lo[a], all.hi[a]);
    for (std::uint32_t c = 0; c < kBvh8Arity; ++c) {
      node.planes[a][0][c] = c < children ? code_of(node, a, 0, from.planes[a][0][c]) : Node::Coding::kMost;
      node.planes[a][1][c] = c < children ? code_of(node, a, 1, from.planes[a][1][c]) : typename Node::Code{0};
    }
  }
  return node;
}

}  // namespace

template <class Node>
Bvh8Of<Node> code_bvh8(const Bvh8& bvh) {
  Bvh8Of<Node> result;
  static_cast<Bvh8Words&>(result) = bvh;
  if constexpr (Node::Block::kIsIndexed) {
    IndexedBlocks indexed = index_blocks(bvh.blocks);
    result.blocks = std::move(indexed.blocks), result.vertices = std::move(indexed.vertices);
  } else {
    result.blocks = bvh.blocks;
  }
  result.nodes = Buffer<Node>(bvh.nodes.size());
  for_chunks(0, bvh.nodes.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) result.nodes[i] = coded<Node>(bvh.nodes[i]);
  });
  return result;
}

template Bvh8Byte code_bvh8<ByteBvh8Node>(const Bvh8&);
template Bvh8Half code_bvh8<HalfBvh8Node>(const Bvh8&);
template Bvh8Compact code_bvh8<CompactBvh8Node>(const Bvh8&);

}  // namespace accel
