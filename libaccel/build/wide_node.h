// Makes a node of a Bvh8 of its children: boxes, references, and their order for each octant (structure/bvh8.h), which is that
// of the boxes' centres along the octant's diagonal.
#pragma once

#include <array>
#include <limits>

#include "libaccel/structure/bvh8.h"

namespace accel {

struct WideChild {
  NodeRef ref;
  Aabb box;
};

namespace wide_node_detail {

// By child and octant: what the place of a child is ordered by, and where it comes.
using Distances = std::array<std::array<float, 8>, kBvh8Arity>;
using Ranks = std::array<std::array<std::uint32_t, 8>, kBvh8Arity>;

inline std::array<float, 8> distances(const Aabb& box) {
  std::array<float, 8> result{};
  for (int a = 0; a < 3; ++a) {
    const float centre = box.lo[a] * 0.5f + box.hi[a] * 0.5f;
    for (std::uint32_t octant = 0; octant < 8; ++octant) result[octant] += (octant >> a & 1u) != 0 ? centre : -centre;
  }
  return result;
}

// Every pair is compared, for all octants at once; equals keep their order.
inline Ranks ranks(const Distances& distances) {
  Ranks rank{};
  for (std::uint32_t c = 1; c < kBvh8Arity; ++c)
    for (std::uint32_t before = 0; before < c; ++before)
      for (std::uint32_t octant = 0; octant < 8; ++octant) {
        const std::uint32_t passes = distances[c][octant] < distances[before][octant] ? 1 : 0;
        rank[before][octant] += passes, rank[c][octant] += 1 - passes;
      }
  return rank;
}

}  // namespace wide_node_detail

inline Bvh8Node make_wide_node(const WideChild* children, std::uint32_t count) {
  Bvh8Node node{};
  wide_node_detail::Distances distances;
  for (std::uint32_t c = 0; c < count; ++c) {
    node.set_child(c, children[c].ref, children[c].box);
    distances[c] = wide_node_detail::distances(children[c].box);
  }
  for (std::uint32_t c = count; c < kBvh8Arity; ++c) {
    node.set_child(c, kNoNode, Aabb{});
    distances[c].fill(-std::numeric_limits<float>::infinity());
  }
  const wide_node_detail::Ranks ranks = wide_node_detail::ranks(distances);
  for (std::uint32_t c = 0; c < kBvh8Arity; ++c)
    for (std::uint32_t octant = 0; octant < 8; ++octant) node.order[ranks[c][octant]] |= c << 3 * octant;
  return node;
}

}  // namespace accel
