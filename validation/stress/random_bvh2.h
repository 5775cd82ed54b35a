// Two-box BVHs that no heuristic would build: what traversers and annotation passes must get right beyond what builders make.
//
// Triangles are shared out at random, in the shapes that degenerate scenes lead to: balanced, skewed, combs that always turn
// the same way, and chains that turn at random. Boxes are tight or too large. Every tree is correct (structure/bvh2.h).
#pragma once

#include <cstdint>

#include "libaccel/geometry/triangle_mesh.h"
#include "libaccel/structure/bvh2.h"

namespace accel::validation {

enum class TreeShape : std::uint8_t { balanced, random, skewed, left_comb, right_comb, chain, zigzag };
inline constexpr TreeShape kTreeShapes[] = {TreeShape::balanced,   TreeShape::random, TreeShape::skewed, TreeShape::left_comb,
                                            TreeShape::right_comb, TreeShape::chain,  TreeShape::zigzag};

struct RandomBvh2Options {
  TreeShape shape = TreeShape::random;
  std::uint32_t leaf_size = 3;     // at most
  std::uint32_t max_depth = 1000;  // below, everything goes into leaves
};

// Over the triangles of a mesh that rays can hit. Without annotations.
Bvh2 random_bvh2(const TriangleMesh& mesh, std::uint64_t seed, const RandomBvh2Options& options = {});

}  // namespace accel::validation
