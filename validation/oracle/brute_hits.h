// All hits of a ray by testing every triangle, as traversers test them, without any structure: the twin of multi-hit queries.
#pragma once

#include <algorithm>
#include <vector>

#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/geometry/packed_triangle.h"
#include "libaccel/trace/multi_hit.h"

namespace accel::validation {

namespace detail {

// Those of one mesh, with prim_ids from first_prim on; the ray is in the mesh's space.
template <class Test>
void append_hits(const TriangleMesh& mesh, std::uint32_t first_prim, const Ray& ray, std::vector<Hit>& hits) {
  if (!is_traceable(ray)) return;
  Hit end;
  begin_hit(ray, end);
  const auto data = Test::prepare(ray);
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    const Triangle triangle = mesh.triangle(t);
    if (!is_in_range(triangle) || is_zero_area(triangle)) continue;
    Hit hit;
    if (!Test::intersect(pack(triangle, t), ray, data, hit) || !(hit.t >= first_t(ray) && hit.t <= end.t)) continue;
    hit.prim_id = first_prim + t;
    hits.push_back(hit);
  }
}

inline std::vector<Hit> in_order(std::vector<Hit> hits) {
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return is_before(place_of(a), place_of(b)); });
  return hits;
}

}  // namespace detail

template <class Test>
std::vector<Hit> all_hits(const TriangleMesh& mesh, const Ray& ray) {
  std::vector<Hit> hits;
  detail::append_hits<Test>(mesh, 0, ray, hits);
  return detail::in_order(std::move(hits));
}

template <class Test>
std::vector<Hit> all_hits(const InstancedMeshes& scene, const Ray& ray) {
  std::vector<Hit> hits;
  if (!is_traceable(ray)) return hits;
  for (std::size_t i = 0; i < scene.instances().size(); ++i) {
    const Instance& instance = scene.instances()[i];
    detail::append_hits<Test>(scene.meshes()[instance.mesh], scene.first_prim(i), inverse(instance.transform)->ray(ray), hits);
  }
  return detail::in_order(std::move(hits));
}

}  // namespace accel::validation
