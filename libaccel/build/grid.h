// Builds a Grid by counting: how many triangles reach into each cell, where each cell's references start, and the references.
//
// Resolution: cells are as cubical as whole numbers allow, and there are as many of them as make rays cheapest by the cost
// model of grid_cost.h. Where they are is as in Cleary and Wyvill 1988 and Wald et al. 2006, "Ray Tracing Animated Scenes using
// Coherent Grid Traversal", section 4.2: along axis a extent_a * cbrt(cells / volume). Deviations: axes that are shorter than
// such a cell get one cell and do not count, so that flat and long scenes get as many cells as others; and the cells a triangle
// are no constant, for scans and rooms want 1 to 4, rooms with much small detail 4 to 8, and teapots in stadiums 64 and more.
// grid_density is the cells a triangle where it is not 0, grid_resolution overrides both, and the report has a note of the
// choice.
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
