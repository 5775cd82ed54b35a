// Ordered traversal of a Bvh8 by single rays with the watertight test, eight boxes or four triangles in SIMD lanes: the twin of
// trace/bvh8_ordered.h, the same steps with the same operations, hence the same hits bit for bit. Compiled for every target of
// the machine's family, by Highway; the best that the machine has runs.
//
// The exact distances of a block's candidates are found in lanes, too. Left to the scalar test are triangles that rounding
// makes hard: those that the ray meets in an edge, and those seen edge-on.
//
// Prediction. From one node's boxes to the next node there is a chain of some fifty cycles, most of a ray's time. Where rays of
// a batch run nearly as the ones before, or are alone, branches choose the next node, so that a machine that predicts them
// begins with it at once: half as fast again. Other batches take it from the stack, which costs no mispredicted branches: a
// tenth faster there.
#pragma once

#include <cstdint>
#include <span>

#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/structure/bvh8.h"

namespace accel {

// The most inner nodes on a path from the root that are accepted, and what may be postponed on such a path: all children but
// one of each node, and all of the last; and room for a whole vector to be stored behind that.
inline constexpr std::uint32_t kMostBvh8Depth = 128;
constexpr std::uint32_t bvh8_stack_size(std::uint32_t depth) { return (kBvh8Arity - 1) * depth + 1 + kBvh8Arity; }

// The tree is no deeper than kMostBvh8Depth. answers[i] is that of rays[i].
void intersect_bvh8_simd(const Bvh8View& view, std::span<const Ray> rays, std::span<Hit> hits);
void occlude_bvh8_simd(const Bvh8View& view, std::span<const Ray> rays, std::span<std::uint8_t> occluded);

// The name of the target that runs: "AVX3" and so on.
const char* bvh8_simd_target();

}  // namespace accel
