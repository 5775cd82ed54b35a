// Small seeded meshes for the tests of builders and structures, and what builders must get right on each.
#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel::test {

inline TriangleMesh mesh_of(const std::vector<Triangle>& triangles) {
  TriangleMesh mesh;
  mesh.vertices = Buffer<Vec3>(3 * triangles.size());
  mesh.triangles = Buffer<IndexTriple>(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    mesh.vertices[3 * i] = triangles[i].v0, mesh.vertices[3 * i + 1] = triangles[i].v1,
                      mesh.vertices[3 * i + 2] = triangles[i].v2;
    mesh.triangles[i] = {3 * i, 3 * i + 1, 3 * i + 2};
  }
  return mesh;
}

inline Vec3 random_point(CounterRng& rng) {
  const float x = rng.next_float(-1, 1), y = rng.next_float(-1, 1), z = rng.next_float(-1, 1);
  return {x, y, z};
}

// Triangles of a given size around random points of [-1, 1]^3.
inline TriangleMesh soup(std::size_t n, float size, std::uint64_t seed = 1) {
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i < n; ++i) {
    CounterRng rng(seed, i);
    const Vec3 p = random_point(rng);
    triangles.push_back({p, p + size * random_point(rng), p + size * random_point(rng)});
  }
  return mesh_of(triangles);
}

// Long thin diagonal triangles, for which spatial splits were invented.
inline TriangleMesh slivers(std::size_t n) {
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i < n; ++i) {
    CounterRng rng(2, i);
    const Vec3 p = random_point(rng), q = random_point(rng);
    triangles.push_back({p, q, q + 0.01f * random_point(rng)});
  }
  return mesh_of(triangles);
}

// A plane of unit quads; flat along z.
inline TriangleMesh flat_grid(int side) {
  std::vector<Triangle> triangles;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const auto at = [](int i, int j) { return Vec3{static_cast<float>(i), static_cast<float>(j), 0.0f}; };
      triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  return mesh_of(triangles);
}

inline TriangleMesh identical(std::size_t n) {
  return mesh_of(std::vector<Triangle>(n, Triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 1}}));
}

// Each triangle twice as large and as far away as the one before: trees over it tend to be chains.
inline TriangleMesh doubling(int n) {
  std::vector<Triangle> triangles;
  for (int i = 0; i < n; ++i) {
    const float s = std::ldexp(1.0f, i - 60);
    triangles.push_back({{s, 0, 0}, {s, s, 0}, {s, 0, s}});
  }
  return mesh_of(triangles);
}

// A soup with triangles that no ray can hit in between.
inline TriangleMesh soup_with_rejects(std::size_t n) {
  TriangleMesh mesh = soup(n, 0.3f, 3);
  for (std::size_t i = 0; i < n; i += 5) {
    Vec3* v = &mesh.vertices[3 * i];
    switch (i / 5 % 4) {
      case 0:
        v[1] = v[0];
        break;
      case 1:
        v[0] = {0, 0, 0}, v[1] = {1, 2, 3}, v[2] = {3, 6, 9};
        break;
      case 2:
        v[2].y = std::numeric_limits<float>::quiet_NaN();
        break;
      default:
        v[0].x = 1e30f;
    }
  }
  return mesh;
}

struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
};
inline std::vector<NamedMesh> all_meshes() {
  return {{"one", soup(1, 0.5f)},           {"two", soup(2, 0.5f)},      {"small soup", soup(3000, 0.02f)},
          {"large soup", soup(1500, 1.0f)}, {"slivers", slivers(2000)},  {"flat", flat_grid(30)},
          {"identical", identical(1000)},   {"doubling", doubling(110)}, {"rejects", soup_with_rejects(500)}};
}

}  // namespace accel::test
