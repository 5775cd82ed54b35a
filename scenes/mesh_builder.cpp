#include "scenes/mesh_builder.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scenes/sphere_grid.h"

namespace accel {
namespace {

// Elements in one task.
constexpr std::uint64_t kBlock = 4096;

// Calls make(part, element within the part, element of the mesh) for all `count` elements. first(part) is where a part starts.
template <class Part, class First, class Make>
void for_each_element(const std::vector<Part>& parts, std::uint64_t count, const First& first, const Make& make) {
  tbb::parallel_for(tbb::blocked_range<std::uint64_t>(0, count, kBlock), [&](const tbb::blocked_range<std::uint64_t>& block) {
    const auto after = [&](std::uint64_t i, const Part& part) { return i < first(part); };
    auto part = std::upper_bound(parts.begin(), parts.end(), block.begin(), after) - 1;
    for (std::uint64_t i = block.begin(); i < block.end(); ++i) {
      while (part + 1 != parts.end() && first(part[1]) <= i) ++part;
      make(*part, static_cast<std::uint32_t>(i - first(*part)), i);
    }
  });
}

}  // namespace

void MeshBuilder::add(std::uint64_t vertices, std::uint64_t triangles, VertexFunction vertex, TriangleFunction triangle) {
  parts_.push_back({vertices_, triangles_, std::move(vertex), std::move(triangle)});
  vertices_ += vertices, triangles_ += triangles;
}

void MeshBuilder::add_grid(std::uint32_t columns, std::uint32_t rows, GridShape shape, SurfaceFunction point) {
  const std::uint32_t across = shape == GridShape::open ? columns + 1 : columns;
  const std::uint32_t along = shape == GridShape::torus ? rows : rows + 1;
  const auto vertex = [=, point = std::move(point)](std::uint32_t i) {
    return point(static_cast<double>(i % across) / columns, static_cast<double>(i / across) / rows);
  };
  const auto triangle = [=](std::uint32_t i) {
    const std::uint32_t quad = i / 2, x = quad % columns, y = quad / columns;
    const std::uint32_t x1 = (x + 1) % across, y1 = (y + 1) % along;
    const std::uint32_t a = y * across + x, b = y * across + x1, c = y1 * across + x1, d = y1 * across + x;
    return i % 2 == 0 ? IndexTriple{a, b, c} : IndexTriple{a, c, d};
  };
  add(std::uint64_t{across} * along, 2ull * columns * rows, vertex, triangle);
}

void MeshBuilder::add_triangle(Vec3d a, Vec3d b, Vec3d c) {
  add(
      3, 1, [=](std::uint32_t i) { return i == 0   ? a
                                          : i == 1 ? b
                                                   : c; },
      [](std::uint32_t) {
        return IndexTriple{0, 1, 2};
      });
}

void MeshBuilder::add_quad(Vec3d a, Vec3d b, Vec3d c, Vec3d d, std::uint32_t divisions) {
  add_grid(divisions, divisions, GridShape::open,
           [=](double u, double v) { return (a * (1 - u) + b * u) * (1 - v) + (d * (1 - u) + c * u) * v; });
}

void MeshBuilder::add_box(Vec3d lo, Vec3d hi) {
  // Corner i has the upper coordinate of axis k where bit k of i is set.
  static constexpr IndexTriple kTriangles[12] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  const auto vertex = [=](std::uint32_t i) { return Vec3d{i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z}; };
  add(8, 12, vertex, [](std::uint32_t i) { return kTriangles[i]; });
}

void MeshBuilder::add_sphere(std::uint32_t frequency, std::function<Vec3d(Vec3d)> point) {
  const SphereGrid grid(frequency);
  add(
      grid.vertices(), grid.triangles(), [grid, point = std::move(point)](std::uint32_t i) { return point(grid.vertex(i)); },
      [grid](std::uint32_t i) { return grid.triangle(i); });
}

void MeshBuilder::add_lathe(Vec3d foot, std::vector<ProfilePoint> profile, std::uint32_t sides) {
  const auto rows = static_cast<std::uint32_t>(profile.size() - 1);
  add_grid(sides, rows, GridShape::tube, [=, profile = std::move(profile)](double u, double v) {
    const ProfilePoint& p = profile[static_cast<std::size_t>(std::lround(v * rows))];
    const double angle = -2 * std::numbers::pi * u;
    return foot + Vec3d{p.radius * std::cos(angle), p.y, p.radius * std::sin(angle)};
  });
}

void MeshBuilder::add_disk(Vec3d center, double radius_x, double radius_z, std::uint32_t sides) {
  const auto vertex = [=](std::uint32_t i) {
    const double angle = -2 * std::numbers::pi * i / sides;
    return i == sides ? center : center + Vec3d{radius_x * std::cos(angle), 0, radius_z * std::sin(angle)};
  };
  add(sides + 1ull, sides, vertex, [=](std::uint32_t i) { return IndexTriple{sides, i, (i + 1) % sides}; });
}

TriangleMesh MeshBuilder::build() const {
  TriangleMesh mesh{Buffer<Vec3>(vertices_), Buffer<IndexTriple>(triangles_)};
  const auto make_vertex = [&](const Part& part, std::uint32_t local, std::uint64_t i) {
    mesh.vertices[i] = part.vertex(local).to_float();
  };
  const auto make_triangle = [&](const Part& part, std::uint32_t local, std::uint64_t i) {
    const IndexTriple t = part.triangle(local);
    const auto base = static_cast<std::uint32_t>(part.first_vertex);
    mesh.triangles[i] = {base + t.v0, base + t.v1, base + t.v2};
  };
  for_each_element(
      parts_, vertices_, [](const Part& part) { return part.first_vertex; }, make_vertex);
  for_each_element(
      parts_, triangles_, [](const Part& part) { return part.first_triangle; }, make_triangle);
  return mesh;
}

}  // namespace accel
