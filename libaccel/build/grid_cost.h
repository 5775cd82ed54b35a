// What rays are expected to cost in a uniform grid, for any number of cells, from a few sums over the triangles: how the
// builder chooses the resolution of a grid.
//
// References. A convex body that lies anywhere reaches into V(body + cell) / V(cell) cells of a grid on average (Santalo 1976,
// "Integral Geometry and Geometric Probability"). For a triangle and p_a inner planes a unit of length along axis a that is
//
//     1 + sum_a width_a p_a + sum_a shadow_a p_b p_c,
//
// with its width along the axis and the area of its projection along the axis, so the sums of these over the triangles tell
// the references of any resolution. They are within 6 % of the true ones in scans and rooms, and low by a share of up to 2 / R,
// of R cells along an axis, where large triangles keep away from the sides of the box.
//
// Lines. A random line that meets a box of volume V and surface A crosses 1 + 2 V / A sum_a p_a cells, and meets any one cell
// with the probability area(cell) / A; it tests the references of the cells that it meets. That is the cost of MacDonald and
// Booth 1990 and the analysis of Cleary and Wyvill 1988, "Analysis of an Algorithm for Fast Ray Tracing Using Uniform Space
// Subdivision". Rays end where they hit something, which the model leaves out: it makes both numbers smaller.
//
// Deviation from these: there are two kinds of lines. Views are of the detail of a scene, and lines through the box of a
// stadium know little of the teapot in it: with them alone all scenes get one to three cells a triangle. So there are lines
// through the core, too, the box that along each axis leaves out the twentieth of the triangles' centres at either end, among
// the triangles whose centres are in it. What a resolution costs is the geometric mean of the two: it is as bad to be slower by
// a factor on one kind as on the other. Core and box are much the same in scans and rooms; then the second kind changes little.
//
// O(triangles) for the sums, O(1) for the cost of a resolution. 12 bytes a triangle while it is made. Deterministic: sums are
// taken in the order of chunks. Any unit of length.
#pragma once

#include <span>

#include "libaccel/build/build_context.h"
#include "libaccel/geometry/packed_triangle.h"
#include "libaccel/structure/grid.h"

namespace accel {

// What entering a cell costs, in steps through a node as BuildOptions::traversal_cost has them: cells of a large grid are
// rarely in the caches. Times of grids over a range of resolutions say 1 triangle test for primary rays and 3 for diffuse ones
// (medians of ten scenes).
inline constexpr double kGridStepCost = 2.0;
// The share of the centres beyond either end of the core, along each axis.
inline constexpr double kGridCoreTail = 0.05;
// The most cells that are considered: so many a triangle, but for few triangles so many in all.
inline constexpr double kMostCellsPerTriangle = 64.0;
inline constexpr double kFreeCells = 1024.0;

// Expected for a line.
struct GridLineCost {
  double cells = 0;
  double tests = 0;
};

class GridCost {
 public:
  // `bounds` is the box of the triangles, of which there is one at least, and each has an area. Runs in the context's arena.
  GridCost(BuildContext& context, std::span<const PackedTriangle> triangles, const Aabb& bounds);

  // The expected number of references of all cells.
  double references(const GridResolution& resolution) const;
  GridLineCost through_box(const GridResolution& resolution) const;
  GridLineCost through_core(const GridResolution& resolution) const;
  // What the two cost, in the unit of the options.
  double cost(const GridResolution& resolution, const BuildOptions& options) const;

  // The number of cells that costs least, of numbers a 16th of an octave apart, among those with at most `most_references`; of
  // equal ones the smallest. One cell is always allowed.
  double cheapest_cells(const BuildOptions& options, double most_references) const;

  const double* core_size() const { return core_.size; }

 private:
  // Sums over triangles.
  struct Sums {
    double triangles = 0;
    double width[3] = {}, shadow[3] = {};
    Sums& operator+=(const Sums& other);
    void add(const Triangle& triangle);
    double references(const double (&planes)[3]) const;
  };
  // Triangles and the box in which lines meet them.
  struct Part : Sums {
    double size[3] = {};
  };
  struct Cells;

  Part make_core(BuildContext& context, std::span<const PackedTriangle> triangles) const;
  GridLineCost through(const Part& part, const GridResolution& resolution) const;

  Aabb bounds_;
  Part box_, core_;
};

}  // namespace accel
