// Every triangle of every instance against the ray, as traversers test them, without any structure: the twin of the methods for
// instanced scenes.
#pragma once

#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/geometry/packed_triangle.h"
#include "libaccel/trace/traverser.h"

namespace accel::validation {

template <class Test>
Hit brute_force(const InstancedMeshes& scene, const Ray& ray) {
  Hit hit;
  begin_hit(ray, hit);
  if (!is_traceable(ray)) return Hit{};
  for (std::size_t i = 0; i < scene.instances().size(); ++i) {
    const Instance& instance = scene.instances()[i];
    const Ray local = inverse(instance.transform)->ray(ray);
    if (!is_traceable(local)) continue;
    const TriangleMesh& mesh = scene.meshes()[instance.mesh];
    const auto data = Test::prepare(local);
    for (std::uint32_t t = 0; t < mesh.size(); ++t) {
      const Triangle triangle = mesh.triangle(t);
      if (!is_in_range(triangle) || is_zero_area(triangle)) continue;
      Hit candidate;
      if (!Test::intersect(pack(triangle, t), local, data, candidate)) continue;
      candidate.prim_id = scene.first_prim(i) + t;
      accept_hit(candidate, first_t(ray), hit);
    }
  }
  finish_hit(hit);
  return hit;
}

}  // namespace accel::validation
