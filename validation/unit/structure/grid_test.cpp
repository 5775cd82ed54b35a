#include "libaccel/structure/grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "libaccel/build/grid.h"
#include "libaccel/structure/grid_stats.h"
#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

constexpr std::uint64_t kGridTriangles = 200;

// A fresh valid grid.
Grid valid_grid() {
  Result<Built<Grid>> built = GridBuilder::build(test::soup(kGridTriangles, 0.2f), {});
  EXPECT_TRUE(built.ok());
  return std::move(built->structure);
}

// What validate() says about a grid that `corrupt` has changed; empty when it finds nothing.
std::string complaint(const std::function<void(Grid&)>& corrupt) {
  Grid grid = valid_grid();
  corrupt(grid);
  const Status status = validate(grid, kGridTriangles);
  return status ? "" : status.message();
}

// The n-th cell that is not empty.
std::uint32_t& full_cell(Grid& grid, int n) {
  for (std::uint32_t& cell : grid.cells)
    if (cell != kEmptyLeaf && n-- == 0) return cell;
  ADD_FAILURE();
  return grid.cells[0];
}

TEST(ValidateGrid, AcceptsGridsAndTheEmptyGrid) {
  EXPECT_EQ(complaint([](Grid&) {}), "");
  EXPECT_TRUE(validate(Grid{}, 0).ok());
}

TEST(ValidateGrid, Resolution) {
  EXPECT_NE(complaint([](Grid& g) { g.frame.resolution.x += 1; }), "");
  EXPECT_NE(complaint([](Grid& g) { g.frame.resolution.y = 0; }), "");
  EXPECT_NE(complaint([](Grid& g) { g.frame.resolution.z = -g.frame.resolution.z; }), "");
  EXPECT_NE(complaint([](Grid& g) { g.frame.resolution.x = kMaxGridResolution + 1; }), "");
  // Two negative numbers whose product is right.
  EXPECT_NE(complaint([](Grid& g) {
              g.frame.resolution = {-g.frame.resolution.x, -g.frame.resolution.y, g.frame.resolution.z};
            }),
            "");
  EXPECT_NE(complaint([](Grid& g) { g.cells.truncate(g.cells.size() - 1); }), "");
  EXPECT_NE(complaint([](Grid& g) { g.cells = {}; }), "");
}

TEST(ValidateGrid, Planes) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis)
    for (const float bad : {nan, infinity, -infinity, 1e19f}) {
      EXPECT_NE(complaint([&](Grid& g) { g.frame.lo[axis] = bad; }), "");
      EXPECT_NE(complaint([&](Grid& g) { g.frame.cell_size[axis] = bad; }), "");
    }
  EXPECT_NE(complaint([](Grid& g) { g.frame.cell_size.y = 0; }), "");
  EXPECT_NE(complaint([](Grid& g) { g.frame.cell_size.z = -1; }), "");
  EXPECT_NE(complaint([](Grid& g) { g.frame.lo.x = 1e18f; }), "") << "all planes coincide";
}

TEST(ValidateGrid, Cells) {
  EXPECT_NE(complaint([](Grid& g) { full_cell(g, 0) += 1; }), "");
  EXPECT_NE(complaint([](Grid& g) { full_cell(g, 3) = full_cell(g, 2); }), "") << "two cells share a leaf";
  EXPECT_NE(complaint([](Grid& g) { std::swap(full_cell(g, 3), full_cell(g, 2)); }), "") << "out of order";
  EXPECT_NE(complaint([](Grid& g) { full_cell(g, 5) = static_cast<std::uint32_t>(g.leaves.references.size()); }), "");
  EXPECT_NE(complaint([](Grid& g) { full_cell(g, 5) = kEmptyLeaf; }), "") << "a leaf that no cell names";
}

TEST(ValidateGrid, References) {
  const auto last = [](Grid& g) -> std::uint32_t& { return g.leaves.references[g.leaves.references.size() - 1]; };
  EXPECT_NE(complaint([&](Grid& g) { last(g) &= ~kLastReference; }), "") << "no end";
  EXPECT_NE(complaint([](Grid& g) { g.leaves.references.truncate(g.leaves.references.size() - 1); }), "");
  EXPECT_NE(complaint([&](Grid& g) { last(g) = kGridTriangles | kLastReference; }), "") << "a slot that is not there";
  EXPECT_NE(complaint([](Grid& g) { g.leaves.references[0] ^= kLastReference; }), "") << "leaves merged or cut";
  EXPECT_NE(complaint([](Grid& g) {
              // The first leaf of two triangles, turned around.
              std::uint32_t* r = g.leaves.references.data();
              while (is_last(*r)) ++r;
              const std::uint32_t second = r[1];
              r[1] = r[0] | (second & kLastReference), r[0] = slot_of(second);
            }),
            "");
}

TEST(ValidateGrid, Triangles) {
  EXPECT_NE(complaint([](Grid& g) { g.leaves.triangles[7].axis[0].word = kGridTriangles; }), "");
  EXPECT_NE(complaint([](Grid& g) { g.leaves.triangles.truncate(g.leaves.triangles.size() - 1); }), "");
  EXPECT_FALSE(validate(valid_grid(), kGridTriangles - 1).ok());
}

TEST(GridFrame, PlanesAscendToTheUpperCorner) {
  const Grid grid = valid_grid();
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < grid.frame.resolution[axis]; ++i)
      EXPECT_LT(grid.frame.plane(axis, static_cast<float>(i)), grid.frame.plane(axis, static_cast<float>(i + 1)));
}

TEST(GridStats, OfAGridMadeByHand) {
  // 2 x 2 x 1 cells of 1 x 1 x 2; one holds both triangles, one the second.
  Grid grid;
  grid.frame = {{0, 0, 0}, {1, 1, 2}, {2, 2, 1}};
  const std::uint32_t cells[] = {kEmptyLeaf, 0, kEmptyLeaf, 2}, references[] = {0, 1 | kLastReference, 1 | kLastReference};
  grid.cells = Buffer<std::uint32_t>::copy_of(cells);
  grid.leaves.references = Buffer<std::uint32_t>::copy_of(references);
  const PackedTriangle triangles[] = {pack({{1, 0, 0}, {2, 0, 0}, {1, 1, 0}}, 0), pack({{1, 0, 1}, {2, 0, 1}, {2, 2, 1}}, 1)};
  grid.leaves.triangles = Buffer<PackedTriangle>::copy_of(triangles);
  ASSERT_TRUE(validate(grid, 2).ok()) << validate(grid, 2).message();

  const GridStats stats = grid_stats(grid, 3, 5);
  EXPECT_EQ(stats.cells, 4u);
  EXPECT_EQ(stats.empty_cells, 2u);
  EXPECT_EQ(stats.empty_share(), 0.5);
  EXPECT_EQ(stats.references, 3u);
  EXPECT_EQ(stats.triangles, 2u);
  EXPECT_EQ(stats.references_per_triangle(), 1.5);
  EXPECT_EQ(stats.fullest_cell, 2u);
  EXPECT_EQ(stats.mean_cell_size, 1.5);
  EXPECT_EQ(stats.cell_size_variance, 0.25);
  EXPECT_EQ(stats.cells_by_size[1], 1u);
  EXPECT_EQ(stats.cells_by_size[2], 1u);
  // A line crosses a cell with the probability 5 / 12.
  EXPECT_DOUBLE_EQ(stats.expected_cost, (4 * 3 + 3 * 5) * 5.0 / 12);
}

TEST(GridStats, OfNothing) {
  const GridStats stats = grid_stats(Grid{}, 1, 1);
  EXPECT_EQ(stats.cells, 0u);
  EXPECT_EQ(stats.expected_cost, 0);
  EXPECT_EQ(stats.empty_share(), 0);
  EXPECT_EQ(stats.references_per_triangle(), 0);
}

TEST(GridStats, CountsAgreeWithTheGrid) {
  const Grid grid = valid_grid();
  const GridStats stats = grid_stats(grid, 1, 1);
  std::uint64_t cells = 0;
  for (const std::uint64_t n : stats.cells_by_size) cells += n;
  EXPECT_EQ(cells, grid.cells.size());
  EXPECT_EQ(stats.cells, grid.frame.resolution.cells());
  EXPECT_EQ(stats.cell_bytes + stats.leaf_bytes, grid.size_bytes());
}

}  // namespace
}  // namespace accel
