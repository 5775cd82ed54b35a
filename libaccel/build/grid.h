// Builds a Grid by counting: how many triangles reach into each cell, where each cell's references start, and the references.
//
// Resolution: cells are as cubical as whole numbers allow, and there are grid_density of them a triangle, as in Cleary and
// Wyvill 1988 and Wald et al. 2006, "Ray Tracing Animated Scenes using Coherent Grid Traversal", section 4.2: along axis a
// extent_a * cbrt(density * triangles / volume), which keeps both steps and tests at O(cbrt(n)) for a ray through an evenly
// filled scene. Deviation: axes that are shorter than such a cell get one cell and do not count, so that flat and long scenes
// get as many cells as others. grid_resolution overrides the rule. The default density, 8, costs at most a quarter more time
// than the best of 1/2 to 64 for most of six scenes and both primary and diffuse rays; scenes of one empty room want 1,
// teapots in stadiums 64 and more.
//
// Memory is bounded: where the cells would hold more than max_references references a triangle (large triangles in a fine
// grid), the number of cells is halved until they do not, and the report has a note; a given resolution is an error then. Up to
// kFreeReferences do not count: few triangles may have many.
//
// Parallel: triangles and cells in chunks, with atomic counters for each cell; sorting each cell's references makes the bytes
// independent of the threads. O(triangles + cells + references log(references of a cell)) and, for large triangles, their
// columns of cells (grid_overlap.h). 48 bytes a triangle, 8 a cell and 4 a reference, and 32 a triangle at the start.
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/structure/grid.h"

namespace accel {

inline constexpr std::uint64_t kFreeReferences = 1u << 16;

// The cells along each axis for a box and a number of cells, as near as whole numbers come: at least one along each axis.
GridResolution choose_grid_resolution(const Aabb& bounds, double cells);

struct GridBuilder {
  static constexpr const char* kName = "grid";
  using Structure = Grid;
  static Result<Built<Grid>> build(const TriangleMesh& mesh, const BuildOptions& options);
};

}  // namespace accel
