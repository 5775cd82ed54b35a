#include "libaccel/build/grid_cost.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "libaccel/build/grid.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/structure/grid_stats.h"
#include "validation/unit/build/builder_checks.h"

namespace accel {
namespace {

GridCost cost_of(const TriangleMesh& mesh) {
  std::vector<PackedTriangle> triangles;
  for (std::uint32_t i = 0; i < mesh.size(); ++i) triangles.push_back(pack(mesh.triangle(i), i));
  const BuildOptions options;
  BuildContext context(mesh, options);
  return {context, triangles, mesh_facts(mesh).bounds};
}

GridResolution chosen_for(const TriangleMesh& mesh, const BuildOptions& options = {}, double most_references = 1e30) {
  return choose_grid_resolution(mesh_facts(mesh).bounds, cost_of(mesh).cheapest_cells(options, most_references));
}

double cells_per_triangle(const TriangleMesh& mesh, const BuildOptions& options = {}) {
  return static_cast<double>(chosen_for(mesh, options).cells()) / static_cast<double>(mesh.size());
}

Grid grid_of(const TriangleMesh& mesh, const GridResolution& r) {
  BuildOptions options;
  options.max_references = 1024;
  for (int a = 0; a < 3; ++a) options.grid_resolution[a] = r[a];
  return test::build<GridBuilder>(mesh, options).structure;
}

// A soup of which all but a twentieth is drawn together to a share of its size.
TriangleMesh teapot_in_stadium(float share) {
  TriangleMesh mesh = test::soup(20000, 0.01f);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (i / 3 % 20 != 0) mesh.vertices[i] = share * mesh.vertices[i];
  return mesh;
}

// The corners of the unit square's half: 1 + both widths + the area.
TEST(GridCost, ReferencesOfATriangleByTheFormula) {
  const GridCost cost = cost_of(test::mesh_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}));
  EXPECT_DOUBLE_EQ(cost.references({1, 1, 1}), 1.0);
  EXPECT_DOUBLE_EQ(cost.references({5, 1, 1}), 1.0 + 4.0);
  EXPECT_DOUBLE_EQ(cost.references({5, 4, 1}), 1.0 + 4.0 + 3.0 + 0.5 * 4 * 3);
}

// The estimate is low where triangles keep away from the outermost half cells, which have no inner planes: by 1 / R for each
// axis, of which areas have two.
TEST(GridCost, ReferencesAndLinesAreThoseOfTheGrid) {
  for (const TriangleMesh& mesh : {test::soup(3000, 0.02f), test::soup(3000, 0.3f), test::slivers(3000)})
    for (const GridResolution& r : {GridResolution{32, 32, 32}, GridResolution{40, 25, 30}}) {
      SCOPED_TRACE(std::to_string(mesh.size()) + " in " + std::to_string(r.x));
      const double share = 2.0 / std::min(r.x, std::min(r.y, r.z));
      const GridCost cost = cost_of(mesh);
      const Grid grid = grid_of(mesh, r);
      const double cells = grid_stats(grid, 1, 0).expected_cost, tests = grid_stats(grid, 0, 1).expected_cost;
      const auto references = static_cast<double>(grid.leaves.references.size());
      EXPECT_NEAR(cost.references(r), references, share * references);
      EXPECT_NEAR(cost.through_box(r).cells, cells, 1e-4 * cells);
      EXPECT_NEAR(cost.through_box(r).tests, tests, share * tests);
    }
}

// Of n points in a cube, R cells an axis: 2 R steps and n / R^2 tests cost least for R = cbrt(n), whatever the core.
TEST(GridCost, PointsInACubeGetACellEach) {
  const GridResolution r = chosen_for(test::soup(8000, 1e-4f));
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(r[a], 20, 1);
}

TEST(GridCost, TheCoreIsWhereTheTrianglesAre) {
  const GridCost even = cost_of(test::soup(20000, 0.01f)), uneven = cost_of(teapot_in_stadium(0.1f));
  const GridResolution r{30, 30, 30};
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(uneven.core_size()[a] / even.core_size()[a], 0.11, 0.03);
  EXPECT_NEAR(even.through_core(r).tests / even.through_box(r).tests, 0.9, 0.1);
  EXPECT_GT(uneven.through_core(r).tests, 20 * uneven.through_box(r).tests);
  EXPECT_LT(uneven.through_core(r).cells, 0.25 * uneven.through_box(r).cells);
}

TEST(GridCost, SmallerDetailGetsMoreCells) {
  double last = cells_per_triangle(teapot_in_stadium(1.0f));
  EXPECT_GT(last, 0.5);
  EXPECT_LT(last, 4.0);
  for (const float share : {0.6f, 0.4f, 0.25f}) {
    const double cells = cells_per_triangle(teapot_in_stadium(share));
    EXPECT_GT(cells, 1.2 * last) << share;
    last = cells;
  }
  EXPECT_GT(last, 8.0);
  EXPECT_NEAR(cells_per_triangle(teapot_in_stadium(0.02f)), kMostCellsPerTriangle, 0.1 * kMostCellsPerTriangle);
}

TEST(GridCost, OptionsMoveTheChoice) {
  const TriangleMesh mesh = test::soup(5000, 0.05f);
  const double cells = cells_per_triangle(mesh);
  BuildOptions options;
  options.traversal_cost = 10;
  EXPECT_LT(cells_per_triangle(mesh, options), 0.5 * cells);
  options.intersection_cost = 10;  // only the ratio counts
  EXPECT_EQ(cells_per_triangle(mesh, options), cells);
  options.traversal_cost = 1;
  EXPECT_GT(cells_per_triangle(mesh, options), 2 * cells);
  options.traversal_cost = 0;  // as fine as can be
  EXPECT_NEAR(cells_per_triangle(mesh, options), kMostCellsPerTriangle, 0.1 * kMostCellsPerTriangle);
  options.intersection_cost = 0;  // it is all one
  EXPECT_EQ(chosen_for(mesh, options), (GridResolution{1, 1, 1}));
}

TEST(GridCost, StaysWithinTheReferences) {
  const TriangleMesh mesh = test::soup(5000, 0.5f);
  const GridCost cost = cost_of(mesh);
  double last = 1e30;
  for (const double most : {1e30, 2e5, 5e4, 1e4, 5e3}) {
    const GridResolution r = chosen_for(mesh, {}, most);
    EXPECT_LE(cost.references(r), most);
    EXPECT_LE(static_cast<double>(r.cells()), last);
    last = static_cast<double>(r.cells());
  }
  EXPECT_EQ(chosen_for(mesh, {}, 0), (GridResolution{1, 1, 1}));
}

TEST(GridCost, DoesNotDependOnTheUnit) {
  TriangleMesh mesh = test::soup(2000, 0.1f);
  const GridResolution r = chosen_for(mesh);
  for (const float scale : {0x1p-60f, 0x1p40f}) {
    TriangleMesh scaled{Buffer<Vec3>::copy_of(mesh.vertices.span()), mesh.triangles};
    for (Vec3& v : scaled.vertices) v = v * scale;
    EXPECT_EQ(chosen_for(scaled), r);
  }
}

TEST(GridCost, LongBoxesGetCubesToo) {
  TriangleMesh mesh = test::soup(4000, 0.01f);
  for (Vec3& v : mesh.vertices) v = {8 * v.x, v.y, 0.5f * v.z};
  const GridResolution r = chosen_for(mesh);
  EXPECT_NEAR(static_cast<double>(r.x) / r.y, 8, 1);
  EXPECT_NEAR(static_cast<double>(r.y) / r.z, 2, 0.5);
}

// Scenes whose sums are zero, and whose core is a point.
TEST(GridCost, FlatAndTinyScenes) {
  const auto in_limits = [](const GridResolution& r, std::size_t triangles) {
    const double most = std::max(kMostCellsPerTriangle * static_cast<double>(triangles), kFreeCells);
    return r.x >= 1 && r.y >= 1 && r.z >= 1 && static_cast<double>(r.cells()) <= 2 * most;
  };
  TriangleMesh flat = test::soup(3000, 0.02f);
  for (Vec3& v : flat.vertices) v.y = 2.0f;
  EXPECT_EQ(chosen_for(flat).y, 1);
  EXPECT_GE(chosen_for(flat).x, 30);
  EXPECT_TRUE(in_limits(chosen_for(flat), flat.size()));
  EXPECT_TRUE(in_limits(chosen_for(test::mesh_of({{{0, 0, 0}, {1, 2, 0}, {1, 0, 3}}})), 1));
  EXPECT_TRUE(in_limits(chosen_for(test::identical(50000)), 50000));
}

TEST(GridCost, AMillionTrianglesAtOnePlace) {
  BuildOptions options;
  options.max_references = 4;
  const Built<Grid> built = test::build<GridBuilder>(test::identical(1'000'000), options);
  EXPECT_LE(built.report.references, 4'000'000u);
  EXPECT_LE(built.structure.cells.size(), 64u);
}

TEST(GridCost, TheReportSaysWhatWasChosen) {
  const TriangleMesh mesh = test::soup(1000, 0.1f);
  const Built<Grid> built = test::build<GridBuilder>(mesh);
  ASSERT_EQ(built.report.notes.size(), 1u);
  const GridResolution r = chosen_for(mesh, {}, kFreeReferences);
  EXPECT_EQ(built.structure.frame.resolution, r);
  EXPECT_EQ(built.report.notes[0].what,
            "a grid of " + std::to_string(r.x) + " x " + std::to_string(r.y) + " x " + std::to_string(r.z) + " cells");
  EXPECT_TRUE(built.report.notes[0].why.starts_with("chosen, ")) << built.report.notes[0].why;
  BuildOptions given;
  given.grid_density = 3;
  EXPECT_TRUE(test::build<GridBuilder>(mesh, given).report.notes.empty());
}

}  // namespace
}  // namespace accel
