// ScalarCulling (packet/breadth_first.h) with the eight children of a node in SIMD lanes: the same operations on each, hence
// the same masks. Compiled for every target of the machine's family, by Highway; the best that the machine has runs.
#pragma once

#include <cstddef>
#include <cstdint>

#include "libaccel/packet/breadth_first.h"

namespace accel {

void cull_simd(const OctoNode* nodes, const Frustum* frustums, const std::uint32_t* frustum, const std::uint32_t* place,
               std::size_t count, std::uint8_t* masks);

struct SimdCulling {
  template <class Primitives>
  static void cull(const OctoNode* nodes, const Frustum* frustums, const FrustumQueue<Primitives>& queue, std::uint8_t* masks) {
    cull_simd(nodes, frustums, queue.frustum.data(), queue.place.data(), queue.count, masks);
  }
};

}  // namespace accel
