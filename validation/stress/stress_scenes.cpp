#include "validation/stress/stress_scenes.h"

#include <cmath>
#include <limits>

#include "validation/stress/hostile_floats.h"

namespace accel::validation {

TriangleMesh mesh_of(const std::vector<Triangle>& triangles) {
  TriangleMesh mesh{Buffer<Vec3>(3 * triangles.size()), Buffer<IndexTriple>(triangles.size())};
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    mesh.vertices[3 * i] = triangles[i].v0, mesh.vertices[3 * i + 1] = triangles[i].v1,
                      mesh.vertices[3 * i + 2] = triangles[i].v2;
    mesh.triangles[i] = {3 * i, 3 * i + 1, 3 * i + 2};
  }
  return mesh;
}

std::vector<Triangle> random_triangles(std::uint32_t count, float size, std::uint64_t seed) {
  std::vector<Triangle> result;
  for (std::uint32_t i = 0; i < count; ++i) {
    CounterRng rng(seed, i);
    const Vec3 center{rng.next_float(), rng.next_float(), rng.next_float()};
    result.push_back(
        {center + random_in_cube(rng, size), center + random_in_cube(rng, size), center + random_in_cube(rng, size)});
  }
  return result;
}

namespace {

// Random triangles in the plane where one coordinate is 0.5: boxes without volume, all at one distance for many rays.
std::vector<Triangle> flat(int axis, std::uint64_t seed) {
  std::vector<Triangle> result = random_triangles(200, 0.2f, seed);
  for (Triangle& t : result) t.v0[axis] = t.v1[axis] = t.v2[axis] = 0.5f;
  return result;
}

// A height field of shared edges on a coarse grid of coordinates, so that vertices lie on split planes.
std::vector<Triangle> terrain(int cells, std::uint64_t seed) {
  const auto vertex = [&](int x, int y) {
    CounterRng rng(seed, static_cast<std::uint64_t>(y * (cells + 1) + x));
    const auto scale = 1.0f / static_cast<float>(cells);
    return Vec3{static_cast<float>(x) * scale, static_cast<float>(rng.next_below(4)) * 0.125f, static_cast<float>(y) * scale};
  };
  std::vector<Triangle> result;
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      result.push_back({vertex(x, y), vertex(x + 1, y), vertex(x, y + 1)});
      result.push_back({vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)});
    }
  return result;
}

// The two triangles of each face of a box.
void add_box(const Aabb& box, std::vector<Triangle>& out) {
  const Vec3 corner[2] = {box.lo, box.hi};
  const auto at = [&](int i) { return Vec3{corner[i & 1].x, corner[i >> 1 & 1].y, corner[i >> 2 & 1].z}; };
  static constexpr int kFaces[6][4] = {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}};
  for (const auto& f : kFaces) {
    out.push_back({at(f[0]), at(f[1]), at(f[2])});
    out.push_back({at(f[0]), at(f[2]), at(f[3])});
  }
}

// Bricks that touch face to face: coplanar triangles, every one of them in a face of its box.
std::vector<Triangle> bricks() {
  std::vector<Triangle> result;
  for (int i = 0; i < 27; ++i) {
    const Vec3 lo{static_cast<float>(i % 3), static_cast<float>(i / 3 % 3), static_cast<float>(i / 9)};
    add_box({lo, lo + Vec3{1, 1, 1}}, result);
  }
  return result;
}

// Boxes inside boxes, each half as large: deep trees, and 2^-40 beside 1.
std::vector<Triangle> nested() {
  std::vector<Triangle> result;
  for (int k = 0; k < 40; ++k) add_box({{0, 0, 0}, {std::ldexp(1.0f, -k), std::ldexp(1.0f, -k), std::ldexp(1.0f, -k)}}, result);
  return result;
}

std::vector<Triangle> slivers(std::uint64_t seed) {
  std::vector<Triangle> result;
  for (std::uint64_t i = 0; i < 300; ++i) {
    CounterRng rng(seed, i);
    const Vec3 a = random_in_cube(rng, 1), b = random_in_cube(rng, 1);
    result.push_back({a, b, a * 0.5f + b * 0.5f + random_in_cube(rng, 1e-5f)});
  }
  return result;
}

// Triangles of which some have no area, coordinates that are not numbers, or coordinates beyond the range.
std::vector<Triangle> broken(std::uint64_t seed) {
  std::vector<Triangle> result = random_triangles(300, 0.3f, seed);
  constexpr float kBad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity(), 3e38f};
  for (std::uint32_t i = 0; i < result.size(); ++i) {
    CounterRng rng(seed + 1, i);
    Triangle& t = result[i];
    if (i % 6 == 1) t.v1 = t.v0;
    if (i % 6 == 2) t.v1 = t.v2 = t.v0;
    if (i % 6 == 3) t.v1[static_cast<int>(rng.next_below(3))] = kBad[rng.next_below(4)];
    if (i % 6 == 4) t = {{0, 0, 0}, {1, 1, 1}, {0.5f, 0.5f, 0.5f}};
  }
  return result;
}

std::vector<Triangle> moved(std::vector<Triangle> triangles, Vec3 offset) {
  for (Triangle& t : triangles) t = {t.v0 + offset, t.v1 + offset, t.v2 + offset};
  return triangles;
}

std::vector<Triangle> repeated(const std::vector<Triangle>& triangles, int times) {
  std::vector<Triangle> result;
  for (int i = 0; i < times; ++i) result.insert(result.end(), triangles.begin(), triangles.end());
  return result;
}

std::vector<Triangle> together(std::vector<Triangle> a, const std::vector<Triangle>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

std::vector<StressScene> stress_scenes(std::uint64_t seed) {
  const Triangle one{{0, 0, 0}, {1, 0, 0.25f}, {0, 1, 0.5f}};
  const Triangle floor{{-1000, 0, -1000}, {1000, 0, -1000}, {0, 0, 2000}};
  std::vector<StressScene> scenes;
  const auto add = [&](const char* name, const std::vector<Triangle>& triangles) {
    scenes.push_back({name, mesh_of(triangles)});
  };
  add("empty", {});
  add("one", {one});
  add("identical", repeated({one}, 100));
  add("duplicates", repeated(random_triangles(100, 0.3f, seed), 3));
  add("flat_x", flat(0, seed));
  add("flat_y", flat(1, seed + 1));
  add("flat_z", flat(2, seed + 2));
  add("soup", random_triangles(500, 0.3f, seed + 3));
  add("dust", random_triangles(500, 1e-3f, seed + 4));
  add("terrain", terrain(16, seed + 5));
  add("bricks", bricks());
  add("nested", nested());
  add("slivers", slivers(seed + 6));
  add("broken", broken(seed + 7));
  add("stadium", together(moved(terrain(12, seed + 8), {500, 0, 300}), {floor}));
  add("far", moved(random_triangles(300, 0.3f, seed + 9), {1e4f, -2e4f, 3e4f}));
  return scenes;
}

}  // namespace accel::validation
