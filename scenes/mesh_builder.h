// Puts scenes together from parametric parts, and computes their vertices and triangles in parallel.
//
// A part says how many vertices and triangles it has and how to make the i-th of each; nothing is computed before build().
// Vertices are made in double and rounded once. Parts do not share vertices with each other. Surfaces wind counter-clockwise
// seen from the side that their formulas call outside.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "libaccel/core/vec3d.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel {

// Which sides of a grid are joined: first and last column (tubes), or also first and last row (tori). Joined sides share
// vertices.
enum class GridShape : std::uint8_t { open, tube, torus };

// A point of the outline that a lathe turns about the y axis.
struct ProfilePoint {
  double radius, y;
};

class MeshBuilder {
 public:
  using VertexFunction = std::function<Vec3d(std::uint32_t)>;
  using TriangleFunction = std::function<IndexTriple(std::uint32_t)>;
  using SurfaceFunction = std::function<Vec3d(double u, double v)>;

  // A part of any kind; triangles name its vertices from 0. The functions are called from several threads.
  void add(std::uint64_t vertices, std::uint64_t triangles, VertexFunction vertex, TriangleFunction triangle);

  // 2 * columns * rows triangles over point(u, v), u in [0, 1] along the columns, v along the rows.
  void add_grid(std::uint32_t columns, std::uint32_t rows, GridShape shape, SurfaceFunction point);

  void add_triangle(Vec3d a, Vec3d b, Vec3d c);

  // The flat or bilinear patch with corners a, b, c, d in order round it, in divisions^2 quads.
  void add_quad(Vec3d a, Vec3d b, Vec3d c, Vec3d d, std::uint32_t divisions = 1);

  // An axis-aligned box: 12 triangles that share 8 vertices.
  void add_box(Vec3d lo, Vec3d hi);

  // A closed surface over the unit sphere: 8 * frequency^2 triangles over point(direction). See sphere_grid.h.
  void add_sphere(std::uint32_t frequency, std::function<Vec3d(Vec3d)> point);

  // The outline turned about the vertical axis through `foot`; open where its ends are off the axis. Points are strictly off
  // the axis.
  void add_lathe(Vec3d foot, std::vector<ProfilePoint> profile, std::uint32_t sides);

  // A horizontal ellipse around `center`, facing up: `sides` triangles round one vertex.
  void add_disk(Vec3d center, double radius_x, double radius_z, std::uint32_t sides);

  std::uint64_t triangle_count() const { return triangles_; }

  // Computes the mesh. At most 2^32 - 1 vertices.
  TriangleMesh build() const;

 private:
  struct Part {
    std::uint64_t first_vertex, first_triangle;
    VertexFunction vertex;
    TriangleFunction triangle;
  };

  std::vector<Part> parts_;
  std::uint64_t vertices_ = 0, triangles_ = 0;
};

}  // namespace accel
