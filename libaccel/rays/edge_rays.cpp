#include <array>
#include <new>
#include <string>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/out_of_memory.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/rays/aim.h"
#include "libaccel/rays/fill.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/rays/scene_box.h"

namespace accel {
namespace {

// Triangles that no ray can hit are drawn again, this often at most: a scene may consist of nothing else.
constexpr int kDraws = 16;

Triangle draw_triangle(const TriangleSource& triangles, CounterRng& rng) {
  Triangle triangle{};
  for (int draw = 0; draw < kDraws; ++draw) {
    triangle = triangles.triangle(rng.next_below(static_cast<std::uint32_t>(triangles.size())));
    if (is_in_range(triangle) && !is_zero_area(triangle)) break;
  }
  return triangle;
}

// A vertex, or a point one to seven eighths along an edge. The fraction is a short binary number, so that the point on the edge
// often is a float; the sum of the two shares is computed in double and rounded once.
Vec3 draw_target(const Triangle& triangle, bool vertex, CounterRng& rng) {
  const std::array<Vec3, 3> corners{triangle.v0, triangle.v1, triangle.v2};
  const std::uint32_t from = rng.next_below(3);
  if (vertex) return corners[from];
  const double share = (1 + rng.next_below(7)) / 8.0;
  return (Vec3d(corners[from]) * (1 - share) + Vec3d(corners[(from + 1) % 3]) * share).to_float();
}

}  // namespace

Result<RaySet> edge_rays(const TriangleSource& triangles, std::uint64_t count, std::uint64_t seed) try {
  if (count > kMaxRays) return Error{"edge rays: " + std::to_string(count) + " are more than 2^32; ask for fewer"};
  if (triangles.size() == 0) return RaySet{};
  const Aabb inner = mesh_facts(triangles).bounds, outer = enlarged(inner, 0.5f);
  RaySet set{Buffer<Ray>(count), {}};
  fill(set.rays.span(), [&](std::size_t i) {
    CounterRng rng(seed, i);
    const Vec3 target = draw_target(draw_triangle(triangles, rng), i % 2 == 0, rng);
    const bool from_inside = (i / 2) % 2 == 0 && !inner.empty();
    return aim(point_in_box(from_inside ? inner : outer, rng), target);
  });
  return set;
} catch (const std::bad_alloc&) {
  return out_of_memory("making edge rays; ask for fewer");
}

}  // namespace accel
