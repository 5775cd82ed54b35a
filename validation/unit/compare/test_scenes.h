// Small meshes and rays for the tests of the oracle and the judge, and a batch traced by brute force.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "libaccel/exec/cpu.h"
#include "libaccel/geometry/moeller_trumbore.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/brute_force.h"

namespace accel::validation::test {

inline TriangleMesh make_mesh(std::vector<Vec3> vertices, std::vector<IndexTriple> triangles) {
  return {Buffer<Vec3>::copy_of(vertices), Buffer<IndexTriple>::copy_of(triangles)};
}

// Two triangles on the unit square at z = 0, sharing the diagonal from (0, 0) to (1, 1).
inline TriangleMesh square() { return make_mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}); }

inline TriangleMesh tetrahedron() {
  return make_mesh({{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}}, {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}});
}

inline TriangleMesh cube() {
  return make_mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}, {{0, 2, 1},
                                                                                                              {0, 3, 2},
                                                                                                              {4, 5, 6},
                                                                                                              {4, 6, 7},
                                                                                                              {0, 1, 5},
                                                                                                              {0, 5, 4},
                                                                                                              {1, 2, 6},
                                                                                                              {1, 6, 5},
                                                                                                              {2, 3, 7},
                                                                                                              {2, 7, 6},
                                                                                                              {3, 0, 4},
                                                                                                              {3, 4, 7}});
}

// A sphere of radius 1: an octahedron whose triangles are cut in four `levels` times.
inline TriangleMesh sphere(int levels) {
  std::vector<Vec3> v{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<IndexTriple> t{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [entry, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(v.size()));
      if (is_new) {
        const Vec3 sum = v[a] + v[b];
        v.push_back(sum * (1 / std::sqrt(dot(sum, sum))));
      }
      return entry->second;
    };
    std::vector<IndexTriple> cut;
    for (const auto [a, b, c] : t) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      cut.insert(cut.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    t = std::move(cut);
  }
  return make_mesh(std::move(v), std::move(t));
}

// v * scale + offset, rounded: vertices that were distinct may meet, edges stay shared.
inline TriangleMesh transformed(const TriangleMesh& mesh, float scale, Vec3 offset) {
  TriangleMesh result{Buffer<Vec3>(mesh.vertices.size()), mesh.triangles};
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) result.vertices[i] = mesh.vertices[i] * scale + offset;
  return result;
}

// The same triangles with no vertex shared.
inline TriangleMesh unshared(const TriangleMesh& mesh) {
  std::vector<Vec3> v;
  std::vector<IndexTriple> t;
  for (std::uint32_t i = 0; i < mesh.size(); ++i) {
    const Triangle triangle = mesh.triangle(i);
    v.insert(v.end(), {triangle.v0, triangle.v1, triangle.v2});
    t.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return make_mesh(std::move(v), std::move(t));
}

using Random = std::mt19937;

inline float uniform(Random& random, float lo, float hi) {
  return lo + (hi - lo) * (static_cast<float>(random() >> 8) * 0x1p-24f);
}
inline Vec3 uniform_point(Random& random, float radius) {
  const float x = uniform(random, -radius, radius), y = uniform(random, -radius, radius);
  return {x, y, uniform(random, -radius, radius)};
}

// Triangles of sizes over many scales in [-1, 1]^3, some of them on a coarse grid so that ties, degenerates and planes occur.
inline TriangleMesh soup(std::size_t count, std::uint32_t seed) {
  Random random(seed);
  std::vector<Vec3> v;
  std::vector<IndexTriple> t;
  for (std::uint32_t i = 0; i < count; ++i) {
    const bool on_grid = i % 4 == 0;
    const Vec3 centre = uniform_point(random, 1);
    const float size = std::exp2(uniform(random, -12, 0));
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = centre + uniform_point(random, size);
      v.push_back(on_grid ? Vec3{std::round(4 * p.x) / 4, std::round(4 * p.y) / 4, std::round(4 * p.z) / 4} : p);
    }
    t.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return make_mesh(std::move(v), std::move(t));
}

// Rays from around `org` through points of edges and through vertices of the mesh.
inline std::vector<Ray> edge_rays(const TriangleMesh& mesh, Vec3 org, float org_radius, std::size_t count, std::uint32_t seed) {
  Random random(seed);
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Triangle t = mesh.triangle(random() % mesh.size());
    const float s = i % 3 == 0 ? 0.0f : uniform(random, 0, 1);
    rays[i].org = org + uniform_point(random, org_radius);
    rays[i].dir = t.v0 + (t.v1 - t.v0) * s - rays[i].org;
  }
  return rays;
}

inline std::vector<LeafQuad> triangle_stream(const TriangleMesh& mesh) {
  std::vector<LeafQuad> stream(mesh.size() * kQuadsPerTriangle + 1);
  for (std::uint32_t i = 0; i < mesh.size(); ++i) {
    reinterpret_cast<PackedTriangle&>(stream[kQuadsPerTriangle * i]) = pack(mesh.triangle(i), i);
  }
  stream.back() = {{0, 0, 0}, kEndOfLeaf};
  return stream;
}

template <class Test>
std::vector<Hit> brute_force(const TriangleMesh& mesh, const std::vector<Ray>& rays) {
  const std::vector<LeafQuad> stream = triangle_stream(mesh);
  std::vector<Hit> hits(rays.size());
  trace_closest<BruteForce<Test, Query::closest>>({stream.data()}, rays, hits, 1);
  return hits;
}

template <class Test>
std::vector<std::uint8_t> brute_force_any(const TriangleMesh& mesh, const std::vector<Ray>& rays) {
  const std::vector<LeafQuad> stream = triangle_stream(mesh);
  std::vector<std::uint8_t> occluded(rays.size());
  trace_any<BruteForce<Test, Query::any>>({stream.data()}, rays, occluded, 1);
  return occluded;
}

}  // namespace accel::validation::test
