#include "libaccel/structure/grid_stats.h"

#include <algorithm>

#include "libaccel/core/vec3d.h"

namespace accel {
namespace {

std::uint32_t cell_size(const Grid& grid, std::uint32_t name) {
  if (name == kEmptyLeaf) return 0;
  std::uint32_t size = 1;
  while (!is_last(grid.leaves.references[name + size - 1])) ++size;
  return size;
}

// Half the area in double: in single precision large grids lose their cells.
double half_area(Vec3d size) { return size.x * (size.y + size.z) + size.y * size.z; }

}  // namespace

GridStats grid_stats(const Grid& grid, float traversal_cost, float intersection_cost) {
  GridStats stats;
  stats.resolution = grid.frame.resolution;
  stats.cells = grid.cells.size();
  stats.triangles = grid.leaves.triangles.size();
  stats.references = grid.leaves.references.size();
  stats.cell_bytes = grid.cells.size_bytes(), stats.leaf_bytes = grid.size_bytes() - stats.cell_bytes;
  if (grid.cells.empty()) return stats;

  stats.cells_by_size.resize(kLargestCountedCell + 1);
  double squares = 0;
  for (const std::uint32_t name : grid.cells) {
    const std::uint32_t size = cell_size(grid, name);
    ++stats.cells_by_size[std::min(size, kLargestCountedCell)];
    stats.fullest_cell = std::max(stats.fullest_cell, size);
    squares += static_cast<double>(size) * size;
  }
  stats.empty_cells = stats.cells_by_size[0];

  const double full = static_cast<double>(std::max<std::uint64_t>(stats.cells - stats.empty_cells, 1));
  stats.mean_cell_size = static_cast<double>(stats.references) / full;
  stats.cell_size_variance = std::max(0.0, squares / full - stats.mean_cell_size * stats.mean_cell_size);

  const Aabb bounds = grid.frame.bounds();
  const double share = half_area(Vec3d(grid.frame.cell_size)) / half_area(Vec3d(bounds.hi) - Vec3d(bounds.lo));
  stats.expected_cost = share * (static_cast<double>(traversal_cost) * static_cast<double>(stats.cells) +
                                 static_cast<double>(intersection_cost) * static_cast<double>(stats.references));
  return stats;
}

}  // namespace accel
