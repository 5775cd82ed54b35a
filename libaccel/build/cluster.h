// What bottom-up builders merge: a box, and what is in it.
#pragma once

#include <cstdint>

#include "libaccel/core/float4_memory_simd.h"

namespace accel {

// A leaf, with a run of references, or an inner node, with two children. Clusters of one array name each other by index; leaves
// come first.
struct alignas(32) Cluster {
  Vec3 lo;
  std::uint32_t first;  // reference of a leaf, or child
  Vec3 hi;
  std::uint32_t second;  // how many references, or child

  Box4 box() const { return {Float4::load_xyz(lo), Float4::load_xyz(hi)}; }
  Aabb bounds() const { return {lo, hi}; }
};
static_assert(sizeof(Cluster) == 32);

inline Cluster make_cluster(const Box4& box, std::uint32_t first, std::uint32_t second) {
  Cluster cluster;
  store_with_word(&cluster.lo, box.lo, first), store_with_word(&cluster.hi, box.hi, second);
  return cluster;
}

}  // namespace accel
