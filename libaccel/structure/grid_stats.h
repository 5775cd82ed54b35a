// What a Grid is like: how full its cells are, and what a ray is expected to cost.
//
// Expected cost: as for trees (MacDonald and Booth 1990), the cost of a random long line that meets the grid's box and stops
// nowhere. It crosses a convex cell with the probability area(cell) / area(grid), so it is the sum over cells of
// (traversal_cost + intersection_cost * references) * area(cell) / area(grid). Cleary and Wyvill 1988, "Analysis of an
// Algorithm for Fast Ray Tracing Using Uniform Space Subdivision", derive the same for cubes.
#pragma once

#include <cstdint>
#include <vector>

#include "libaccel/structure/grid.h"

namespace accel {

struct GridStats {
  GridResolution resolution;
  std::uint64_t cells = 0;
  std::uint64_t empty_cells = 0;
  std::uint64_t triangles = 0;   // each counted once
  std::uint64_t references = 0;  // in the cells
  std::uint32_t fullest_cell = 0;
  double mean_cell_size = 0;      // triangles in a cell that is not empty
  double cell_size_variance = 0;  // of those cells
  double expected_cost = 0;
  std::vector<std::uint64_t> cells_by_size;  // [n]: cells with n triangles; the last entry counts all larger ones too
  std::uint64_t cell_bytes = 0, leaf_bytes = 0;

  double empty_share() const { return cells > 0 ? static_cast<double>(empty_cells) / static_cast<double>(cells) : 0.0; }
  double references_per_triangle() const {
    return triangles > 0 ? static_cast<double>(references) / static_cast<double>(triangles) : 0.0;
  }
};

// The last entry of cells_by_size.
inline constexpr std::uint32_t kLargestCountedCell = 32;

// One pass over a valid grid: O(cells + references).
GridStats grid_stats(const Grid& grid, float traversal_cost, float intersection_cost);

}  // namespace accel
