// Makes a node of a Bvh8 of its children: boxes, references, and their order for each octant (structure/bvh8.h), which is that
// of the boxes' centres along the octant's diagonal.
//
// What comes first for an octant comes last for the opposite one: four octants, which are ranked at once, have the answers for
// eight. Children whose centres are equally far come as they are for octants 0 to 3, and the other way round for the others.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <limits>

#include "libaccel/core/float4_memory_simd.h"
#include "libaccel/structure/bvh8.h"

namespace accel {

struct WideChild {
  NodeRef ref;
  Box4 box;
};

namespace wide_node_detail {

constexpr std::uint32_t kRanked = 4;  // octants
// By octant: a child's place in the order, in bits of a word that has a byte for each place.
using Places = std::array<std::uint32_t, kRanked>;
using Distances = std::array<float, kRanked>;

// Of the point whose coordinates are `step` apart. Octants 0 to 3 look backwards along z.
inline Distances distances(const float* centre, std::size_t step) {
  const float x = centre[0], y = centre[step], z = centre[2 * step];
  return {(-x - y) - z, (x - y) - z, (y - x) - z, (x + y) - z};
}

// Every pair is compared, for all octants at once; equals keep their order.
inline void rank(const Distances* distances, std::uint32_t count, Places* places) {
  for (std::uint32_t c = 0; c < count; ++c) places[c] = {};
  for (std::uint32_t c = 1; c < count; ++c)
    for (std::uint32_t before = 0; before < c; ++before)
      for (std::uint32_t octant = 0; octant < kRanked; ++octant) {
        const std::uint32_t passes = distances[c][octant] < distances[before][octant] ? 8 : 0;
        places[before][octant] += passes, places[c][octant] += 8 - passes;
      }
}

// The bytes of the children in their order, for each octant; places without a child come last.
inline std::array<std::uint64_t, 8> orders(const Places* places, std::uint32_t count) {
  constexpr std::uint64_t kAll = 0x0706050403020100;
  const std::uint64_t absent = count < kBvh8Arity ? kAll >> 8 * count << 8 * count : 0;
  std::array<std::uint64_t, 8> order{};
  for (std::uint32_t c = 0; c < count; ++c)
    for (std::uint32_t octant = 0; octant < kRanked; ++octant) order[octant] |= std::uint64_t{c} << places[c][octant];
  for (std::uint32_t octant = 0; octant < kRanked; ++octant) {
    order[7 - octant] = __builtin_bswap64(order[octant]) >> (64 - 8 * count) | absent;
    order[octant] |= absent;
  }
  return order;
}

}  // namespace wide_node_detail

// Of at least one child.
inline void make_wide_node(const WideChild* children, std::uint32_t count, Bvh8Node& node) {
  using namespace wide_node_detail;
  Float4 lo[kBvh8Arity], hi[kBvh8Arity];
  for (std::uint32_t c = 0; c < kBvh8Arity; ++c) {
    const bool is_there = c < count;
    lo[c] = is_there ? children[c].box.lo : Box4{}.lo, hi[c] = is_there ? children[c].box.hi : Box4{}.hi;
    node.child[c] = is_there ? children[c].ref : kNoNode;
  }
  float centres[3][kBvh8Arity];
  for (std::uint32_t half = 0; half < kBvh8Arity; half += 4) {
    Float4 lower[3], upper[3];
    transpose(lo + half, lower), transpose(hi + half, upper);
    const Float4 one_half = Float4::splat(0.5f);
    for (int a = 0; a < 3; ++a) {
      store(node.planes[a][0] + half, lower[a]), store(node.planes[a][1] + half, upper[a]);
      store(centres[a] + half, lower[a] * one_half + upper[a] * one_half);
    }
  }

  Distances distance[kBvh8Arity];
  Places places[kBvh8Arity];
  for (std::uint32_t c = 0; c < count; ++c) distance[c] = distances(centres[0] + c, kBvh8Arity);
  rank(distance, count, places);
  const std::array<std::uint64_t, 8> order = orders(places, count);
  std::uint64_t pairs[4];
  for (std::uint32_t p = 0; p < 4; ++p) pairs[p] = order[2 * p] | order[2 * p + 1] << 3;
  for (std::uint32_t i = 0; i < kBvh8Arity; ++i) {
    std::uint64_t word = 0;
    for (std::uint32_t p = 0; p < 4; ++p) word |= (pairs[p] >> 8 * i & 63) << 6 * p;
    node.order[i] = static_cast<std::uint32_t>(word);
  }
}

}  // namespace accel
