#include "libaccel/build/grid_overlap.h"

namespace accel {
namespace {

constexpr double kSlack = 64 * 0x1p-53;

double largest_of(double a, double b, double c) { return std::fmax(std::fabs(a), std::fmax(std::fabs(b), std::fabs(c))); }

}  // namespace

GridAxis::GridAxis(const GridFrame& frame, int axis, double pad)
    : origin_(frame.lo[axis]), boxes_(static_cast<std::size_t>(frame.resolution[axis])) {
  inverse_size_ = 1.0 / static_cast<double>(frame.cell_size[axis]);
  double lower = 0;
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    const double upper = static_cast<double>(frame.plane(axis, static_cast<float>(i + 1))) - origin_;
    boxes_[i] = {0.5 * (lower + upper), 0.5 * (upper - lower) + pad};
    lower = upper;
  }
}

int GridAxis::guess(double at) const {
  return static_cast<int>(std::fmin(std::fmax(at * inverse_size_, 0.0), static_cast<double>(cells() - 1)));
}

int GridAxis::first_cell(double at) const {
  int cell = guess(at);
  while (cell > 0 && upper(cell - 1) >= at) --cell;
  while (cell + 1 < cells() && upper(cell) < at) ++cell;
  return cell;
}

int GridAxis::last_cell(double at) const {
  int cell = guess(at);
  while (cell + 1 < cells() && lower(cell + 1) <= at) ++cell;
  while (cell > 0 && lower(cell) > at) --cell;
  return cell;
}

GridCells::GridCells(const GridFrame& frame, Vec3d pad) : axis{{frame, 0, pad.x}, {frame, 1, pad.y}, {frame, 2, pad.z}} {
  stride[0] = 1;
  stride[1] = static_cast<std::uint32_t>(frame.resolution.x);
  stride[2] = static_cast<std::uint32_t>(frame.resolution.x) * static_cast<std::uint32_t>(frame.resolution.y);
  const Vec3d size = Vec3d(frame.bounds().hi) - Vec3d(frame.lo);
  extent = largest_of(size.x, size.y, size.z);
}

TriangleCells::TriangleCells(const GridCells& cells, const Triangle& t) : cells_(cells) {
  const Vec3 vertices[3] = {t.v0, t.v1, t.v2};
  double q[3][3];  // by vertex and axis, relative to the grid
  int wide = 0;    // axes along which the triangle's box has more than one cell
  for (int a = 0; a < 3; ++a) {
    for (int i = 0; i < 3; ++i) q[i][a] = vertices[i][a] - cells.axis[a].origin();
    first_[a] = cells.axis[a].first_cell(std::fmin(q[0][a], std::fmin(q[1][a], q[2][a])));
    last_[a] = cells.axis[a].last_cell(std::fmax(q[0][a], std::fmax(q[1][a], q[2][a])));
    wide += last_[a] > first_[a];
  }
  tested_ = wide > 1;
  if (!tested_) return;

  double e[2][3];
  for (int a = 0; a < 3; ++a) e[0][a] = q[1][a] - q[0][a], e[1][a] = q[2][a] - q[0][a];
  const double normal[3] = {e[0][1] * e[1][2] - e[0][2] * e[1][1], e[0][2] * e[1][0] - e[0][0] * e[1][2],
                            e[0][0] * e[1][1] - e[0][1] * e[1][0]};
  const double n = largest_of(normal[0], normal[1], normal[2]);
  w_ = std::fabs(normal[0]) == n ? 0 : std::fabs(normal[1]) == n ? 1 : 2;
  u_ = next(w_), v_ = next(u_);
  set_plane(q, normal);
  set_edges(q);
}

void TriangleCells::set_plane(const double (&q)[3][3], const double (&normal)[3]) {
  // A normal that vanished in rounding says nothing: any axis will do.
  const bool vanished = !(std::fabs(normal[w_]) > 0);
  slope_u_ = vanished ? 0.0 : normal[u_] / normal[w_];
  slope_v_ = vanished ? 0.0 : normal[v_] / normal[w_];
  const auto height = [&](int i) { return q[i][w_] + slope_u_ * q[i][u_] + slope_v_ * q[i][v_]; };
  const double slack = kSlack * cells_.extent;
  plane_lo_ = std::fmin(height(0), std::fmin(height(1), height(2))) - slack;
  plane_hi_ = std::fmax(height(0), std::fmax(height(1), height(2))) + slack;
}

void TriangleCells::set_edges(const double (&q)[3][3]) {
  for (int axis = 0; axis < 3; ++axis) {
    const int a = next(axis), b = next(a);
    for (int i = 0; i < 3; ++i) {
      EdgeAxis& edge = edges_[axis][i];
      edge.ka = q[i][b] - q[next(i)][b], edge.kb = q[next(i)][a] - q[i][a];
      const auto height = [&](int vertex) { return edge.ka * q[vertex][a] + edge.kb * q[vertex][b]; };
      const double slack = kSlack * std::fmax(std::fabs(edge.ka), std::fabs(edge.kb)) * cells_.extent;
      edge.lo = std::fmin(height(0), std::fmin(height(1), height(2))) - slack;
      edge.hi = std::fmax(height(0), std::fmax(height(1), height(2))) + slack;
    }
  }
}

void TriangleCells::clip_column(int u, int v, int& first, int& last) const {
  const Box &box_u = cells_.axis[u_].box(u), &box_v = cells_.axis[v_].box(v);
  const double center = slope_u_ * box_u.center + slope_v_ * box_v.center;
  const double reach = std::fabs(slope_u_) * box_u.half + std::fabs(slope_v_) * box_v.half;
  first = std::max(first, cells_.axis[w_].first_cell(plane_lo_ - center - reach));
  last = std::min(last, cells_.axis[w_].last_cell(plane_hi_ - center + reach));
}

}  // namespace accel
