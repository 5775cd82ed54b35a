#include "libaccel/build/grid.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <vector>

#include "libaccel/build/grid_overlap.h"
#include "libaccel/core/ray.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/structure/grid_stats.h"
#include "libaccel/structure/padding.h"
#include "validation/unit/build/builder_checks.h"

namespace accel {
namespace {

using test::same_bytes;

Built<Grid> build_grid(const TriangleMesh& mesh, const BuildOptions& options = {}) {
  return test::build<GridBuilder>(mesh, options);
}

BuildOptions with_resolution(int x, int y, int z) {
  BuildOptions options;
  options.grid_resolution[0] = x, options.grid_resolution[1] = y, options.grid_resolution[2] = z;
  options.max_references = 1024;
  return options;
}

// Whether a polygon that is clipped by the six faces of a box has anything left: another way to the answer of the builder's
// separating axes. In double, whose errors are far below a thousandth of any pad.
bool meets_box(const Triangle& t, const double (&lo)[3], const double (&hi)[3]) {
  // Most triangles lie beyond one of the faces, and nothing of them is left.
  const Aabb bounds = t.bounds();
  for (int a = 0; a < 3; ++a)
    if (bounds.hi[a] < lo[a] || bounds.lo[a] > hi[a]) return false;
  using Point = std::array<double, 3>;
  std::vector<Point> polygon, next;
  for (const Vec3 v : {t.v0, t.v1, t.v2}) polygon.push_back({v.x, v.y, v.z});
  for (int face = 0; face < 6 && !polygon.empty(); ++face) {
    const int a = face / 2;
    const double sign = face % 2 == 0 ? 1 : -1, limit = face % 2 == 0 ? lo[a] : -hi[a];
    const auto height = [&](const Point& p) { return sign * p[static_cast<std::size_t>(a)] - limit; };
    next.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double hp = height(p), hq = height(q);
      if (hp >= 0) next.push_back(p);
      if ((hp > 0 && hq < 0) || (hp < 0 && hq > 0)) {
        const double s = hp / (hp - hq);
        next.push_back({p[0] + s * (q[0] - p[0]), p[1] + s * (q[1] - p[1]), p[2] + s * (q[2] - p[2])});
      }
    }
    polygon.swap(next);
  }
  return !polygon.empty();
}

// Every cell has the triangles that come within 0.999 pads of it, and none that do not come within 1.001.
void expect_right_cells(const TriangleMesh& mesh, const Grid& grid) {
  const Vec3d pad = cell_padding(mesh_facts(mesh).bounds);
  const double pads[3] = {pad.x, pad.y, pad.z};
  const GridResolution& r = grid.frame.resolution;
  for (int z = 0, cell = 0; z < r.z; ++z)
    for (int y = 0; y < r.y; ++y)
      for (int x = 0; x < r.x; ++x, ++cell) {
        std::vector<bool> has(grid.leaves.triangles.size());
        const std::uint32_t name = grid.cells[static_cast<std::size_t>(cell)];
        for (std::uint32_t i = name; name != kEmptyLeaf; ++i) {
          has[slot_of(grid.leaves.references[i])] = true;
          if (is_last(grid.leaves.references[i])) break;
        }
        double lo[2][3], hi[2][3];
        const int index[3] = {x, y, z};
        for (int a = 0; a < 3; ++a)
          for (int k = 0; k < 2; ++k) {
            const double margin = pads[a] * (k == 0 ? 0.999 : 1.001);
            lo[k][a] = grid.frame.plane(a, static_cast<float>(index[a])) - margin;
            hi[k][a] = grid.frame.plane(a, static_cast<float>(index[a] + 1)) + margin;
          }
        for (std::size_t slot = 0; slot < has.size(); ++slot) {
          const Triangle t = grid.leaves.triangles[slot].vertices();
          EXPECT_TRUE(has[slot] || !meets_box(t, lo[0], hi[0])) << "slot " << slot << " is missing in cell " << cell;
          EXPECT_TRUE(!has[slot] || meets_box(t, lo[1], hi[1])) << "slot " << slot << " is not near cell " << cell;
        }
      }
}

TEST(GridBuilder, NothingToBuildIsAnEmptyGrid) {
  for (const TriangleMesh& mesh : test::empty_meshes()) {
    const Built<Grid> built = build_grid(mesh);
    EXPECT_TRUE(built.structure.cells.empty());
    EXPECT_EQ(built.report.skipped.zero_area, mesh.size());
  }
}

TEST(GridBuilder, CellsHaveTheTrianglesNearThem) {
  for (const auto& [name, mesh] : test::all_meshes()) {
    if (mesh.size() > 1600) continue;  // quadratic
    SCOPED_TRACE(name);
    BuildOptions options;
    options.grid_density = 500.0f / static_cast<float>(mesh.size());
    options.max_references = 1024;
    expect_right_cells(mesh, build_grid(mesh, options).structure);
  }
}

TEST(GridBuilder, LargeTrianglesFillTheCellsThatTheyPass) {
  expect_right_cells(test::slivers(40), build_grid(test::slivers(40), with_resolution(16, 15, 14)).structure);
  expect_right_cells(test::soup(40, 2.0f), build_grid(test::soup(40, 2.0f), with_resolution(13, 16, 9)).structure);
  // Edges along axes, in planes of the grid, and diagonal.
  std::vector<Triangle> triangles;
  for (int i = 0; i <= 8; ++i) {
    const auto c = static_cast<float>(i);
    triangles.push_back({{c, 0, 0}, {c, 8, 0}, {c, 0, 8}});
    triangles.push_back({{0, c, 0}, {8, c, 8}, {8, c, 0}});
    triangles.push_back({{0, 0, c}, {8, 8, c}, {8, 0, c}});
    triangles.push_back({{0, 0, c}, {8, 8, c}, {8, 8, 8}});
    triangles.push_back({{c, 0, 0}, {0, 8, 0}, {0, 0, 8}});
  }
  expect_right_cells(test::mesh_of(triangles), build_grid(test::mesh_of(triangles), with_resolution(8, 8, 8)).structure);
}

// What a box of cells would cost: a diagonal triangle reaches into a share of it.
TEST(GridBuilder, ALargeTriangleDoesNotFillItsBox) {
  const Built<Grid> built = build_grid(test::mesh_of({{{0, 0, 0}, {1, 1, 0}, {1, 0, 1}}}), with_resolution(64, 64, 64));
  EXPECT_LT(built.report.references, 2u * 3 * 64 * 64);
  EXPECT_GT(built.report.references, 64u * 64 / 2);
}

TEST(GridBuilder, ScalesAndOffsets) {
  const TriangleMesh mesh = test::soup(60, 0.4f);
  for (const float scale : {1e-30f, 1e-12f, 1.0f, 1e10f, 1e17f})
    for (const float offset : {0.0f, 1.0f, 3e4f}) {
      TriangleMesh moved{Buffer<Vec3>::copy_of(mesh.vertices.span()), mesh.triangles};
      for (Vec3& v : moved.vertices) v = (v + Vec3{offset, -offset, 0.1f * offset}) * scale;
      if (!in_range(moved.vertices[0])) continue;
      SCOPED_TRACE(std::to_string(scale) + " " + std::to_string(offset));
      expect_right_cells(moved, build_grid(moved, with_resolution(6, 7, 5)).structure);
    }
}

// Farther from the origin than floats can tell cells apart: planes coincide, and nothing is lost.
TEST(GridBuilder, FlatCells) {
  std::vector<Triangle> triangles;
  for (int i = 0; i < 30; ++i) {
    CounterRng rng(4, static_cast<std::uint64_t>(i));
    const auto c = [&] { return 1e6f + 0.0625f * static_cast<float>(rng.next_below(4)); };
    const auto point = [&] {
      const float x = c(), y = c(), z = rng.next_float();
      return Vec3{x, y, z};
    };
    const Vec3 a = point(), b = point(), p = point();
    triangles.push_back({a, b, p});
  }
  const TriangleMesh mesh = test::mesh_of(triangles);
  const Grid grid = build_grid(mesh, with_resolution(20, 20, 3)).structure;
  expect_right_cells(mesh, grid);
}

TEST(GridBuilder, ReportAgreesWithTheGrid) {
  for (const auto& [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    const Built<Grid> built = build_grid(mesh);
    const GridStats stats = grid_stats(built.structure, 1, 1);
    test::expect_true_report(mesh, built, stats);
    EXPECT_TRUE(built.structure.frame.bounds().contains(mesh_facts(mesh).bounds));
  }
}

TEST(GridBuilder, BytesDoNotDependOnThreads) { test::expect_same_bytes_for_any_threads<GridBuilder>(test::soup(70000, 0.05f)); }

// The bound makes grids coarser, in the same way for any number of threads, down to one cell.
TEST(GridBuilder, ReferencesStayWithinTheirBound) {
  const tbb::global_control more_threads(tbb::global_control::max_allowed_parallelism, 4);
  const TriangleMesh mesh = test::soup(10000, 0.5f);
  BuildOptions options;
  options.grid_density = 0.5f;
  options.max_references = 1024.0f;
  const Built<Grid> unbound = build_grid(mesh, options);
  EXPECT_TRUE(unbound.report.notes.empty());
  ASSERT_GT(unbound.report.references, kFreeReferences);

  std::uint64_t last = 1;
  for (const float share : {0.0f, 0.8f, 0.95f}) {
    const float most = std::max(1.0f, share * static_cast<float>(unbound.report.references) / 10000.0f);
    options.max_references = most, options.threads = 0;
    const Built<Grid> built = build_grid(mesh, options);
    EXPECT_LE(static_cast<double>(built.report.references), std::max(most * 10000.0, static_cast<double>(kFreeReferences)));
    EXPECT_LT(built.structure.cells.size(), unbound.structure.cells.size());
    EXPECT_GE(built.structure.cells.size(), last);
    EXPECT_FALSE(built.report.notes.empty());
    last = built.structure.cells.size();
    options.threads = 4;
    EXPECT_TRUE(same_bytes(built.structure, build_grid(mesh, options).structure));
  }
  BuildOptions one;
  one.max_references = 1.0f;
  EXPECT_EQ(build_grid(test::soup(70000, 2.0f), one).structure.cells.size(), 1u);
}

TEST(GridBuilder, AResolutionBeyondTheBoundIsAnError) {
  BuildOptions options = with_resolution(50, 50, 50);
  options.max_references = 4.0f;
  const Result<Built<Grid>> built = GridBuilder::build(test::soup(3000, 1.0f), options);
  ASSERT_FALSE(built.ok());
  EXPECT_NE(built.message().find("max_references"), std::string::npos) << built.message();
}

TEST(GridBuilder, AGivenResolutionIsKept) {
  const Grid grid = build_grid(test::soup(500, 0.1f), with_resolution(50, 40, 1)).structure;
  EXPECT_EQ(grid.frame.resolution, (GridResolution{50, 40, 1}));
}

TEST(GridBuilder, IdenticalTrianglesShareTheirCells) {
  const Built<Grid> built = build_grid(test::identical(1000));
  EXPECT_EQ(built.report.references % 1000, 0u);
  EXPECT_LE(built.report.references, kFreeReferences);
}

TEST(GridBuilder, ProgressCanInterrupt) { test::expect_progress_interrupts<GridBuilder>(); }

TEST(GridBuilder, MeaninglessOptionsAreRefused) {
  const auto refuses = [](auto change) { return test::refuses<GridBuilder>(change); };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.grid_resolution[1] = 5; }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o = with_resolution(5, -1, 5); }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o = with_resolution(5, 5, kMaxGridResolution + 1); }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o = with_resolution(60000, 60000, 60000); }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.grid_density = -1; }));
  EXPECT_TRUE(refuses([&](BuildOptions& o) { o.grid_density = nan; }));
}

TEST(GridResolutionRule, CellsAreNearlyCubesAndAsManyAsAskedFor) {
  EXPECT_EQ(choose_grid_resolution({{0, 0, 0}, {1, 1, 1}}, 1000), (GridResolution{10, 10, 10}));
  EXPECT_EQ(choose_grid_resolution({{0, 0, 0}, {4, 2, 1}}, 8000), (GridResolution{40, 20, 10}));
  EXPECT_EQ(choose_grid_resolution({{-1e-30f, 0, 0}, {1e-30f, 2e-30f, 2e-30f}}, 64), (GridResolution{4, 4, 4}));
}

TEST(GridResolutionRule, AxesShorterThanACellGetOne) {
  EXPECT_EQ(choose_grid_resolution({{0, 0, 0}, {1, 1, 0}}, 100), (GridResolution{10, 10, 1}));
  EXPECT_EQ(choose_grid_resolution({{0, 0, 0}, {1, 1, 1e-6f}}, 100), (GridResolution{10, 10, 1}));
  EXPECT_EQ(choose_grid_resolution({{0, 0, 0}, {1e6f, 1, 0.5f}}, 100), (GridResolution{100, 1, 1}));
  EXPECT_EQ(choose_grid_resolution({{0, 5, 0}, {0, 5, 3}}, 7), (GridResolution{1, 1, 7}));
}

TEST(GridResolutionRule, StaysWithinItsLimits) {
  EXPECT_EQ(choose_grid_resolution({{0, 0, 0}, {1, 1, 1}}, 0), (GridResolution{1, 1, 1}));
  for (const Vec3 size : {Vec3{1, 1, 1}, Vec3{1, 1e-3f, 1}, Vec3{1.5f, 1, 1e9f}, Vec3{1e-9f, 1e-9f, 1e9f}}) {
    const GridResolution r = choose_grid_resolution({{0, 0, 0}, size}, 1e30);
    EXPECT_LE(r.cells(), kMaxGridCells);
    for (int a = 0; a < 3; ++a) {
      EXPECT_GE(r[a], 1);
      EXPECT_LE(r[a], kMaxGridResolution);
    }
  }
}

}  // namespace
}  // namespace accel
