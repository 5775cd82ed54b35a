// kd-trees that no heuristic would build: what traversers and annotation passes must get right beyond what builders make.
//
// Planes are drawn at random: anywhere in the cell, at coordinates of vertices, one float beside a face of the cell, and at
// few places again and again, so that trees are deep, cells flat, and many planes met at one distance. Leaves are empty, full
// of everything, or what is left. Every tree is correct (structure/kdtree.h): triangles are in all leaves that their padded
// boxes touch.
#pragma once

#include <cstdint>

#include "libaccel/geometry/triangle_mesh.h"
#include "libaccel/structure/kdtree.h"

namespace accel::validation {

struct RandomKdTreeOptions {
  std::uint32_t max_depth = 12;
  std::uint32_t leaf_size = 4;      // nodes with as few triangles become leaves, most of them
  std::uint32_t max_nodes = 20000;  // from here on, nodes become leaves
};

// Over the triangles of a mesh that rays can hit. Without extra arrays.
KdTree random_kdtree(const TriangleMesh& mesh, std::uint64_t seed, const RandomKdTreeOptions& options = {});

}  // namespace accel::validation
