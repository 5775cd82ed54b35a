#include "validation/stress/stress_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <tuple>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/float_bounds.h"
#include "scenes/procedural.h"
#include "validation/stress/closed_meshes.h"
#include "validation/stress/hostile_floats.h"
#include "validation/stress/stress_cells.h"

namespace accel::validation {
namespace {

using Triangles = std::vector<Triangle>;

std::uint32_t pick(SceneSize size, std::uint32_t small, std::uint32_t large) {
  return size == SceneSize::small ? small : large;
}

// `count` triangles, number i by make(rng of i).
template <class Make>
Triangles made(std::uint32_t count, std::uint64_t seed, const Make& make) {
  Triangles result;
  result.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    CounterRng rng(seed, i, 5);
    result.push_back(make(rng));
  }
  return result;
}

std::vector<StressScene> scene(const char* name, const Triangles& triangles) { return {{name, mesh_of(triangles)}}; }

TriangleMesh scaled(const TriangleMesh& mesh, int exponent) {
  TriangleMesh result{Buffer<Vec3>::copy_of(mesh.vertices.span()), mesh.triangles};
  for (Vec3& v : result.vertices) v = {std::ldexp(v.x, exponent), std::ldexp(v.y, exponent), std::ldexp(v.z, exponent)};
  return result;
}

TriangleMesh builtin(const std::string& spec, std::uint64_t seed) {
  const Result<SceneData> data = make_builtin(spec, seed);
  if (!data) throw std::runtime_error(data.message());
  return *data->one_mesh();
}

// The scenes of a list that have one of the names.
std::vector<StressScene> named(std::vector<StressScene> scenes, const std::set<std::string>& names) {
  std::erase_if(scenes, [&](const StressScene& s) { return !names.contains(s.name); });
  return scenes;
}

void append(std::vector<StressScene>& scenes, std::vector<StressScene> more) {
  for (StressScene& s : more) scenes.push_back(std::move(s));
}

std::vector<StressScene> closed_at(std::initializer_list<double> offsets, SceneSize size, std::uint64_t seed) {
  std::vector<StressScene> scenes;
  for (const ClosedMesh& closed : closed_meshes(pick(size, 200, 100'000), seed))
    for (const double offset : offsets)
      scenes.push_back({closed.name + " at " + std::to_string(static_cast<long>(offset)), placed(closed.mesh, {1, offset})});
  return scenes;
}

// A quad in a plane of constant z.
void add_quad(Vec3 lo, float width, float height, Triangles& out) {
  const Vec3 u{width, 0, 0}, v{0, height, 0};
  out.push_back({lo, lo + u, lo + u + v});
  out.push_back({lo, lo + u + v, lo + v});
}

}  // namespace

std::vector<StressScene> empty_scenes(SceneSize, std::uint64_t) { return scene("empty", {}); }

std::vector<StressScene> usual_scenes(SceneSize size, std::uint64_t seed) {
  if (size == SceneSize::small) {
    std::vector<StressScene> scenes = named(stress_scenes(seed), {"soup", "terrain", "bricks", "stadium"});
    scenes.push_back({"bumpy", closed_meshes(200, seed)[3].mesh});
    return scenes;
  }
  std::vector<StressScene> scenes;
  for (const char* name : {"soup:20000", "terrain:50000", "spheres:50000", "hairball:50000", "stadium:50000"})
    scenes.push_back({name, builtin(name, seed)});
  append(scenes, named(stress_scenes(seed), {"bricks", "slivers"}));
  return scenes;
}

std::vector<StressScene> assorted_scenes(SceneSize, std::uint64_t seed) { return stress_scenes(seed); }
std::vector<StressScene> lattices(SceneSize, std::uint64_t seed) { return cell_stress_scenes(seed); }

std::vector<StressScene> scaled_scenes(SceneSize size, std::uint64_t seed) {
  std::vector<StressScene> scenes = usual_scenes(size, seed), result;
  for (const int k : {-40, -17, 17, 40})
    for (const StressScene& s : scenes) result.push_back({s.name + " times 2^" + std::to_string(k), scaled(s.mesh, k)});
  return result;
}

std::vector<StressScene> translated_scenes(SceneSize size, std::uint64_t seed) {
  return closed_at({0, 1, 1e2, 1e4}, size, seed);
}
std::vector<StressScene> far_translated_scenes(SceneSize size, std::uint64_t seed) { return closed_at({1e6}, size, seed); }

std::vector<StressScene> sliver_scenes(SceneSize size, std::uint64_t seed) {
  return scene("slivers", made(pick(size, 300, 100'000), seed, [](CounterRng& rng) {
                 const Vec3 a = random_in_cube(rng, 1), b = random_in_cube(rng, 1);
                 return Triangle{a, b, a * 0.5f + b * 0.5f + random_in_cube(rng, 1e-7f)};
               }));
}

std::vector<StressScene> needle_scenes(SceneSize size, std::uint64_t seed) {
  return scene("needles", made(pick(size, 300, 100'000), seed, [](CounterRng& rng) {
                 const Vec3 a = random_in_cube(rng, 1), b = random_in_cube(rng, 1);
                 return Triangle{a, b, a + random_in_cube(rng, 1e-7f)};
               }));
}

std::vector<StressScene> zero_area_scenes(SceneSize size, std::uint64_t seed) {
  const std::uint32_t count = pick(size, 100, 100'000);
  // Sixteenths, so that the middle of an edge is a float.
  const auto grid_point = [](CounterRng& rng) {
    const auto x = rng.next_below(16), y = rng.next_below(16), z = rng.next_below(16);
    return Vec3{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)} * 0.0625f;
  };
  return {{"points", mesh_of(made(count, seed,
                                  [&](CounterRng& rng) {
                                    const Vec3 p = random_in_cube(rng, 1);
                                    return Triangle{p, p, p};
                                  }))},
          {"doubled vertices", mesh_of(made(count, seed,
                                            [&](CounterRng& rng) {
                                              const Vec3 a = random_in_cube(rng, 1), b = random_in_cube(rng, 1);
                                              return rng.next_below(2) == 0 ? Triangle{a, b, a} : Triangle{a, b, b};
                                            }))},
          {"segments", mesh_of(made(count, seed, [&](CounterRng& rng) {
             const Vec3 a = grid_point(rng), b = grid_point(rng);
             return Triangle{a, b, a * 0.5f + b * 0.5f};
           }))}};
}

std::vector<StressScene> partly_zero_area_scenes(SceneSize size, std::uint64_t seed) {
  Triangles all = random_triangles(pick(size, 100, 100'000), 0.2f, seed);
  const std::size_t count = all.size();
  for (std::size_t i = 0; i < count; i += 2) {
    const Triangle t = all[i];
    all.push_back({t.v0, t.v1, t.v0}), all.push_back({t.v2, t.v2, t.v2});
  }
  return scene("partly without area", all);
}

std::vector<StressScene> one_many_times(SceneSize size, std::uint64_t) {
  return scene("one, many times", Triangles(pick(size, 300, 1'000'000), Triangle{{0, 0, 0}, {1, 0, 0.25f}, {0, 1, 0.5f}}));
}

std::vector<StressScene> few_many_times(SceneSize size, std::uint64_t seed) {
  const Triangles few = random_triangles(100, 0.3f, seed);
  Triangles all;
  for (std::uint32_t i = 0; i < pick(size, 4, 1000); ++i) all.insert(all.end(), few.begin(), few.end());
  return scene("hundred, many times", all);
}

std::vector<StressScene> stacks_of_planes(SceneSize size, std::uint64_t) {
  std::vector<StressScene> scenes;
  for (const float start : {1.0f, 1000.0f}) {
    Triangles apart;
    float height = start;
    for (std::uint32_t i = 0; i < pick(size, 150, 20'000); ++i, height = next_up(height))
      add_quad({static_cast<float>(i % 10) * 0.125f, static_cast<float>(i % 7) * 0.25f, height}, 1, 1, apart);
    scenes.push_back({"one float apart from " + std::to_string(static_cast<int>(start)), mesh_of(apart)});
  }
  Triangles coplanar;
  for (std::uint32_t i = 0; i < pick(size, 150, 2'000); ++i)
    add_quad({static_cast<float>(i % 10) * 0.125f, static_cast<float>(i % 7) * 0.25f, 1}, 1, 1, coplanar);
  scenes.push_back({"coplanar", mesh_of(coplanar)});
  return scenes;
}

// Strips of a plane, each of quads of another width: vertices of one lie within edges of the next.
std::vector<StressScene> t_junctions(SceneSize size, std::uint64_t seed) {
  Triangles strips;
  for (std::uint32_t row = 0; row < pick(size, 12, 300); ++row) {
    const std::uint32_t quads = 1 + row * 7 % 32;
    const float width = 8.0f / static_cast<float>(quads);
    for (std::uint32_t i = 0; i < quads; ++i)
      add_quad({static_cast<float>(i) * width, static_cast<float>(row), 0}, width, 1, strips);
  }
  // And the same turned into the diagonal, where vertices on edges are rounded.
  Triangles turned = strips;
  CounterRng rng(seed, 0);
  const float tilt = 0.3f + 0.1f * rng.next_float();
  for (Triangle& t : turned)
    for (Vec3* v : {&t.v0, &t.v1, &t.v2}) *v = {v->x * 0.8f - v->y * 0.6f, v->x * 0.6f + v->y * 0.8f, v->x * tilt};
  return {{"junctions", mesh_of(strips)}, {"turned junctions", mesh_of(turned)}};
}

std::vector<StressScene> flat_scenes(SceneSize size, std::uint64_t seed) {
  std::vector<StressScene> scenes;
  for (int axis = 0; axis < 3; ++axis) {
    Triangles flat = random_triangles(pick(size, 200, 100'000), size == SceneSize::small ? 0.2f : 0.01f, seed);
    for (Triangle& t : flat) t.v0[axis] = t.v1[axis] = t.v2[axis] = 0.3f;
    scenes.push_back({"flat in axis " + std::to_string(axis), mesh_of(flat)});
  }
  return scenes;
}

// Triangles across an axis, at places of their own: boxes without extent, and with that of one float.
std::vector<StressScene> thin_boxes(SceneSize size, std::uint64_t seed) {
  return scene("thin boxes", made(pick(size, 300, 100'000), seed, [](CounterRng& rng) {
                 Triangle t{random_in_cube(rng, 1), random_in_cube(rng, 1), random_in_cube(rng, 1)};
                 const auto axis = static_cast<int>(rng.next_below(3));
                 t.v0[axis] = t.v1[axis] = t.v2[axis];
                 if (rng.next_below(2) != 0) t.v0[axis] = next_up(t.v0[axis]);
                 return t;
               }));
}

// Two opposite corners and a point within their box: the middle of every box is (1, 2, 3), exactly.
std::vector<StressScene> one_centroid(SceneSize size, std::uint64_t seed) {
  return scene("one centroid", made(pick(size, 300, 1'000'000), seed, [](CounterRng& rng) {
                 const auto coordinate = [&] { return static_cast<float>(1 + rng.next_below(1024)) * 0x1p-11f; };
                 const float x = coordinate(), y = coordinate(), z = coordinate();
                 const Vec3 center{1, 2, 3}, half{x, y, z};
                 return Triangle{center - half, center + half, center + half * random_in_cube(rng, 1)};
               }));
}

std::vector<StressScene> diagonal_slivers(SceneSize size, std::uint64_t seed) {
  return scene("diagonal slivers", made(pick(size, 300, 200'000), seed, [](CounterRng& rng) {
                 const Vec3 start = random_in_cube(rng, 0.1f), end = Vec3{1, 1, 1} + random_in_cube(rng, 0.1f);
                 return Triangle{start, end, end + random_in_cube(rng, 1e-3f)};
               }));
}

std::vector<StressScene> deep_trees(SceneSize size, std::uint64_t seed) {
  std::vector<StressScene> scenes = named(stress_scenes(seed), {"nested"});
  // Combs of triangles, each half as large and as far away as the one before.
  Triangles comb;
  for (int k = 0; k < 90; ++k) {
    const float s = std::ldexp(1.0f, 30 - k);
    comb.push_back({{s, 0, 0}, {s, s * 0.25f, 0}, {s, 0, s * 0.25f}});
  }
  scenes.push_back({"comb", mesh_of(comb)});
  scenes.push_back({"deep", builtin(size == SceneSize::small ? "deep:1000" : "deep:1000000", seed)});
  return scenes;
}

std::vector<StressScene> world_among_dust(SceneSize size, std::uint64_t seed) {
  const bool small = size == SceneSize::small;
  Triangles all = random_triangles(small ? 300 : 1'000'000, small ? 1e-2f : 1e-3f, seed);
  all.insert(all.begin() + 100, {{-1e6f, 0.5f, -1e6f}, {1e6f, 0.5f, -1e6f}, {0, 0.5f, 2e6f}});
  all.push_back({{-3, -3, -3}, {4, 4, -3}, {0.5f, 0.5f, 5}});
  return scene("world among dust", all);
}

std::vector<StressScene> broken_coordinates(SceneSize size, std::uint64_t seed) {
  Triangles all = random_triangles(pick(size, 300, 100'000), 0.3f, seed);
  constexpr float kBad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -2e18f, 3e38f};
  for (std::uint32_t i = 0; i < all.size(); i += 3) {
    CounterRng rng(seed, i, 6);
    (&all[i].v0)[rng.next_below(3)][static_cast<int>(rng.next_below(3))] = kBad[rng.next_below(4)];
  }
  std::vector<StressScene> scenes = scene("broken coordinates", all);
  for (Triangle& t : all) t.v0.x = kBad[0];
  scenes.push_back({"nothing but broken coordinates", mesh_of(all)});
  return scenes;
}

std::vector<StressScene> broken_indices(SceneSize, std::uint64_t seed) {
  TriangleMesh mesh = mesh_of(random_triangles(100, 0.3f, seed));
  mesh.triangles[57].v1 = static_cast<std::uint32_t>(mesh.vertices.size());
  return {{"an index too many", mesh}};
}

TriangleMesh without_copies(const TriangleMesh& mesh) {
  const auto key = [](Vec3 v) { return std::tuple(v.x, v.y, v.z); };
  const auto key_of = [&](const Triangle& t) { return std::tuple(key(t.v0), key(t.v1), key(t.v2)); };
  Triangles firsts;
  std::set<decltype(key_of(Triangle{}))> seen;
  for (std::size_t i = 0; i < mesh.size() && seen.insert(key_of(mesh.triangle(i))).second; ++i)
    firsts.push_back(mesh.triangle(i));
  return mesh_of(firsts);
}

}  // namespace accel::validation
