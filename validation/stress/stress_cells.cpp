#include "validation/stress/stress_cells.h"

#include <cmath>
#include <limits>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/float_bounds.h"
#include "libaccel/structure/padding.h"
#include "validation/stress/hostile_floats.h"

namespace accel::validation {
namespace {

// A unit quad across `axis`, as two triangles.
void add_quad(int axis, Vec3 lo, float size, std::vector<Triangle>& out) {
  Vec3 u{}, v{};
  u[(axis + 1) % 3] = size, v[(axis + 2) % 3] = size;
  out.push_back({lo, lo + u, lo + u + v});
  out.push_back({lo, lo + u + v, lo + v});
}

// Quads in the planes of a lattice, some left out: every plane is shared, every edge too.
std::vector<Triangle> quad_lattice(std::uint64_t seed) {
  std::vector<Triangle> result;
  CounterRng rng(seed, 0);
  for (int cell = 0; cell < 64; ++cell)
    for (int axis = 0; axis < 3; ++axis)
      if (rng.next_below(3) != 0)
        add_quad(axis, {static_cast<float>(cell % 4), static_cast<float>(cell / 4 % 4), static_cast<float>(cell / 16)}, 1,
                 result);
  return result;
}

// A thousand quads in one plane, or each one float above the last.
std::vector<Triangle> stack_of_planes(bool coincident) {
  std::vector<Triangle> result;
  float height = 1.0f;
  for (int i = 0; i < 1000; ++i) {
    const auto place = static_cast<float>(i % 10) * 0.125f;
    add_quad(2, {place, place, height}, 1, result);
    if (!coincident) height = next_up(height);
  }
  return result;
}

// A checkerboard across one axis: a scene without thickness.
std::vector<Triangle> board(int axis) {
  std::vector<Triangle> result;
  for (int i = 0; i < 64; i += 1 + i / 8 % 2) {
    Vec3 lo{0.5f, 0.5f, 0.5f};
    lo[(axis + 1) % 3] = static_cast<float>(i % 8), lo[(axis + 2) % 3] = static_cast<float>(i / 8);
    add_quad(axis, lo, 1, result);
  }
  return result;
}

TriangleMesh scaled(const std::vector<Triangle>& triangles, int exponent) {
  TriangleMesh mesh = mesh_of(triangles);
  const float scale = std::ldexp(1.0f, exponent);
  for (Vec3& v : mesh.vertices) v = v * scale;
  return mesh;
}

Aabb bounds_of(const TriangleMesh& mesh) {
  Aabb bounds;
  for (const Vec3& v : mesh.vertices) bounds.extend(v);
  return bounds;
}

class RayMaker {
 public:
  RayMaker(const TriangleMesh& mesh, const Aabb& bounds, std::uint64_t seed, std::uint64_t element)
      : mesh_(mesh), bounds_(bounds), rng_(seed, element) {}

  static constexpr std::uint64_t kKinds = 7;
  Ray make(std::uint64_t kind) {
    switch (kind) {
      case 0:
        return along_an_axis(vertex());
      case 1:
        return along_an_axis(beside(vertex()));
      case 2:
        return in_a_plane(vertex());
      case 3:
        return in_a_plane(beside(vertex()));
      case 4:
        return along_the_box();
      case 5:
        return {.org = vertex(), .dir = vertex() - vertex()};
      default:
        return with_denormals();
    }
  }

  Ray make_far(float extents) {
    const Vec3 size = bounds_.extent();
    const float largest = size[largest_axis(size)];
    const Vec3 target = inside();
    Ray ray{.org = target + random_in_cube(rng_, 1) * (extents * largest)};
    ray.dir = target - ray.org;
    return ray;
  }

 private:
  int axis() { return static_cast<int>(rng_.next_below(3)); }
  float zero() { return rng_.next_below(2) != 0 ? 0.0f : -0.0f; }
  float sign() { return rng_.next_below(2) != 0 ? 1.0f : -1.0f; }
  Triangle triangle() { return mesh_.triangle(rng_.next_below(static_cast<std::uint32_t>(mesh_.size()))); }
  Vec3 vertex() {
    const Triangle t = triangle();
    const std::uint32_t i = rng_.next_below(3);
    return i == 0 ? t.v0 : i == 1 ? t.v1 : t.v2;
  }
  Vec3 inside() {
    const Triangle t = triangle();
    const float u = rng_.next_float() * 0.5f, v = rng_.next_float() * 0.5f;
    return t.v0 * (1.0f - u - v) + t.v1 * u + t.v2 * v;
  }
  Vec3 beside(Vec3 p) {
    for (int a = 0; a < 3; ++a) {
      const std::uint32_t side = rng_.next_below(3);
      if (side != 0) p[a] = side == 1 ? next_up(p[a]) : next_down(p[a]);
    }
    return p;
  }

  // Through a point, from it or from outside.
  Ray along_an_axis(Vec3 point) {
    const int a = axis();
    Ray ray{.org = point, .dir = {zero(), zero(), zero()}};
    ray.dir[a] = sign();
    if (rng_.next_below(3) != 0) ray.org[a] -= 2.0f * ray.dir[a] * bounds_.extent()[a];
    return ray;
  }

  // In the plane of constant coordinate through a point.
  Ray in_a_plane(Vec3 point) {
    const int a = axis();
    Ray ray{.org = point, .dir = inside() - point};
    if (rng_.next_below(2) != 0) ray.org = ray.org - ray.dir * 2.0f;
    ray.org[a] = point[a], ray.dir[a] = zero();
    return ray;
  }

  // Along an edge or a face of the box of the scene, or of the box that padding makes of it.
  Ray along_the_box() {
    const Aabb box = rng_.next_below(2) != 0 ? bounds_ : padded(bounds_, cell_padding(bounds_));
    const int a = axis();
    Ray ray{.dir = {zero(), zero(), zero()}};
    for (int b = 0; b < 3; ++b) ray.org[b] = rng_.next_below(2) != 0 ? box.lo[b] : box.hi[b];
    ray.dir[a] = ray.org[a] == box.lo[a] ? 1.0f : -1.0f;
    const int other = (a + 1) % 3;
    if (rng_.next_below(2) != 0) ray.dir[other] = (ray.org[other] == box.lo[other] ? 1.0f : -1.0f) * rng_.next_float();
    if (rng_.next_below(2) != 0) ray.org = ray.org - ray.dir * bounds_.extent()[a];
    return ray;
  }

  Ray with_denormals() {
    Ray ray = along_an_axis(inside());
    for (int a = 0; a < 3; ++a)
      if (ray.dir[a] == 0) ray.dir[a] = random_over_exponents(rng_, -149, -127);
    return ray;
  }

  const TriangleMesh& mesh_;
  const Aabb& bounds_;
  CounterRng rng_;
};

template <class Make>
std::vector<Ray> make_rays(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed, const Make& make) {
  std::vector<Ray> rays;
  if (mesh.size() == 0) return rays;
  const Aabb bounds = bounds_of(mesh);
  for (std::uint64_t i = 0; i < count; ++i) {
    RayMaker maker(mesh, bounds, seed, i);
    const Ray ray = make(maker, i);
    if (is_traceable(ray)) rays.push_back(ray);
  }
  return rays;
}

}  // namespace

std::vector<StressScene> cell_stress_scenes(std::uint64_t seed) {
  std::vector<StressScene> scenes;
  scenes.push_back({"lattice", mesh_of(quad_lattice(seed))});
  scenes.push_back({"lattice times 2^40", scaled(quad_lattice(seed), 40)});
  scenes.push_back({"lattice times 2^-40", scaled(quad_lattice(seed), -40)});
  scenes.push_back({"coincident planes", mesh_of(stack_of_planes(true))});
  scenes.push_back({"planes one float apart", mesh_of(stack_of_planes(false))});
  for (int axis = 0; axis < 3; ++axis) scenes.push_back({"board across axis " + std::to_string(axis), mesh_of(board(axis))});
  return scenes;
}

std::vector<Ray> cell_stress_rays(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
  return make_rays(mesh, count, seed, [](RayMaker& maker, std::uint64_t i) { return maker.make(i % RayMaker::kKinds); });
}

std::vector<Ray> far_rays(const TriangleMesh& mesh, float extents, std::size_t count, std::uint64_t seed) {
  return make_rays(mesh, count, seed, [=](RayMaker& maker, std::uint64_t) { return maker.make_far(extents); });
}

}  // namespace accel::validation
