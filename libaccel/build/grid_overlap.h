// Which cells of a grid a triangle reaches into, within the grid's padding.
//
// The separating-axis test of Akenine-Moeller 2001, "Fast 3D Triangle-Box Overlap Testing", arranged as in Schwarz and Seidel
// 2010, "Fast Parallel Surface and Solid Voxelization on GPUs": all that depends on the triangle alone is computed once; the
// cells of its box are visited in columns along the dominant axis of its normal; a column is refused by its projection, and
// within it the plane leaves one to three cells. So a large diagonal triangle costs as many steps as it covers columns, not
// cells of its box. Deviation: edges are tested as intervals and not as half-planes, which knows no orientation and so does not
// fail for triangles seen edge-on.
//
// Conservative: no cell that is within the pad of the triangle is left out. Coordinates are doubles relative to the grid's
// lower corner, off by at most u S (u = 2^-53, S the largest extent of the grid). Every axis is a valid separating axis,
// however it was rounded, so only the projections onto it have errors that matter: with |k| the largest component of the axis,
// 9 u |k| S for a vertex and 27 u |k| S for the centre and the half-extent of a box. Intervals are widened by kSlack = 64 u |k|
// S, which covers the division by the normal's dominant component too; it is a 2^-30th of the pad.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "libaccel/core/vec3d.h"
#include "libaccel/structure/grid.h"

namespace accel {

// The cells along one axis.
class GridAxis {
 public:
  GridAxis() = default;
  GridAxis(const GridFrame& frame, int axis, double pad);

  // The first cell that ends, and the last that starts, within the pad of a position; clamped to the grid.
  int first_cell(double at) const;
  int last_cell(double at) const;

  double origin() const { return origin_; }
  int cells() const { return static_cast<int>(boxes_.size()); }

  // A padded cell.
  struct Box {
    double center, half;
  };
  const Box& box(int cell) const { return boxes_[static_cast<std::size_t>(cell)]; }

 private:
  double lower(int cell) const { return box(cell).center - box(cell).half; }
  double upper(int cell) const { return box(cell).center + box(cell).half; }
  int guess(double at) const;

  double origin_ = 0, inverse_size_ = 0;
  std::vector<Box> boxes_;
};

// The cells of a grid, as overlap tests want them.
struct GridCells {
  GridCells(const GridFrame& frame, Vec3d pad);

  GridAxis axis[3];
  std::uint32_t stride[3];
  double extent;  // the largest
};

// One triangle against the cells of a grid.
class TriangleCells {
 public:
  TriangleCells(const GridCells& cells, const Triangle& triangle);

  // Calls visit(cell) for every cell that the triangle reaches into, each once.
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (int v = first_[v_]; v <= last_[v_]; ++v)
      for (int u = first_[u_]; u <= last_[u_]; ++u)
        if (in_shadow(w_, u, v)) visit_column(u, v, visit);
  }

 private:
  using Box = GridAxis::Box;

  // The projection of the triangle onto an axis ka * a + kb * b of the plane of two coordinates.
  struct EdgeAxis {
    double ka, kb, lo, hi;
    bool meets(const Box& a, const Box& b) const {
      const double center = ka * a.center + kb * b.center;
      const double reach = std::fabs(ka) * a.half + std::fabs(kb) * b.half;
      return center + reach >= lo && center - reach <= hi;
    }
  };

  static constexpr int next(int axis) { return axis == 2 ? 0 : axis + 1; }

  void set_plane(const double (&q)[3][3], const double (&normal)[3]);
  void set_edges(const double (&q)[3][3]);

  // Whether the projections of the triangle and of a cell along `axis` meet; a and b number the cell along the next axes.
  bool in_shadow(int axis, int a, int b) const {
    if (!tested_) return true;
    const Box &box_a = cells_.axis[next(axis)].box(a), &box_b = cells_.axis[next(next(axis))].box(b);
    const EdgeAxis* const edges = edges_[axis];
    return edges[0].meets(box_a, box_b) && edges[1].meets(box_a, box_b) && edges[2].meets(box_a, box_b);
  }

  template <class Visit>
  void visit_column(int u, int v, const Visit& visit) const {
    int first = first_[w_], last = last_[w_];
    if (tested_) clip_column(u, v, first, last);
    const std::uint32_t column =
        static_cast<std::uint32_t>(u) * cells_.stride[u_] + static_cast<std::uint32_t>(v) * cells_.stride[v_];
    for (int w = first; w <= last; ++w)
      if (in_shadow(u_, v, w) && in_shadow(v_, w, u)) visit(column + static_cast<std::uint32_t>(w) * cells_.stride[w_]);
  }

  // Cuts the cells of a column down to those that the triangle's plane passes through.
  void clip_column(int u, int v, int& first, int& last) const;

  const GridCells& cells_;
  int first_[3], last_[3];                                          // the cells of the triangle's box
  bool tested_ = true;                                              // false: the triangle reaches into all cells of its box
  int u_ = 0, v_ = 1, w_ = 2;                                       // w_ is the dominant axis of the normal
  double slope_u_ = 0, slope_v_ = 0, plane_lo_ = 0, plane_hi_ = 0;  // plane_lo <= w + slope_u u + slope_v v <= plane_hi
  EdgeAxis edges_[3][3];                                            // by the axis of projection, and by edge
};

}  // namespace accel
