#include "libaccel/structure/grid.h"

#include <string>

#include "libaccel/core/ray.h"

namespace accel {
namespace {

constexpr const char* kAxisNames[] = {"x", "y", "z"};

Status validate_axis(const GridFrame& frame, int axis) {
  const std::string name = kAxisNames[axis];
  const std::int32_t cells = frame.resolution[axis];
  if (cells < 1 || cells > kMaxGridResolution)
    return Error{"there are " + std::to_string(cells) + " cells along " + name + "; there must be 1 to " +
                 std::to_string(kMaxGridResolution)};
  // Coordinates up to the library's limit, and a pad around them.
  const float limit = 2.0f * kMaxCoordinate;
  const float first = frame.lo[axis], last = frame.last_plane(axis);
  if (!(frame.cell_size[axis] > 0.0f && first >= -limit && last <= limit && first < last))
    return Error{"the planes along " + name + " do not ascend, or are out of range"};
  return Done{};
}

// Passes over the run that starts at `first`; returns the index behind it, or an error.
Result<std::uint64_t> end_of_run(const ReferenceLeaves& leaves, std::uint64_t first) {
  for (std::uint64_t i = first; i < leaves.references.size(); ++i) {
    const std::uint32_t reference = leaves.references[i];
    if (is_last(reference)) return i + 1;
    if (i + 1 < leaves.references.size() && slot_of(leaves.references[i + 1]) <= reference)
      return Error{"the slots of the leaf at reference " + std::to_string(first) + " do not ascend"};
  }
  return Error{"the leaf at reference " + std::to_string(first) + " has no end"};
}

Status validate_cells(const Grid& grid) {
  std::uint64_t next = 0;  // where the next run starts
  for (std::size_t cell = 0; cell < grid.cells.size(); ++cell) {
    if (grid.cells[cell] == kEmptyLeaf) continue;
    if (grid.cells[cell] != next)
      return Error{"cell " + std::to_string(cell) + " names the leaf at reference " + std::to_string(grid.cells[cell]) +
                   "; in the order of cells it must be " + std::to_string(next)};
    const Result<std::uint64_t> end = end_of_run(grid.leaves, next);
    if (!end) return end.error();
    next = *end;
  }
  if (next != grid.leaves.references.size())
    return Error{"the cells name " + std::to_string(next) + " references, but there are " +
                 std::to_string(grid.leaves.references.size())};
  return Done{};
}

}  // namespace

Status validate(const Grid& grid, std::uint64_t triangle_count) {
  if (grid.cells.empty()) {
    if (grid.leaves.triangles.empty() && grid.leaves.references.empty()) return Done{};
    return Error{"there are no cells, but there are triangles or references"};
  }
  for (int axis = 0; axis < 3; ++axis)
    if (Status status = validate_axis(grid.frame, axis); !status) return status;
  const std::uint64_t cells = grid.frame.resolution.cells();
  if (cells > kMaxGridCells || cells != grid.cells.size())
    return Error{"there are " + std::to_string(grid.cells.size()) + " cells, but the resolution asks for " +
                 std::to_string(cells)};
  if (Status status = validate(grid.leaves, triangle_count); !status) return status;
  return validate_cells(grid);
}

}  // namespace accel
