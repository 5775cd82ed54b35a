// A scene made of instances: meshes, each placed any number of times by an affine map.
//
// prim_id. The triangles of instance i have the consecutive numbers first_prim(i) + their number in the mesh, so that a Hit
// names instance and triangle in one word, and files, pictures and judges know nothing new. place_of() undoes it by binary
// search. A scene may have up to 2^32 - 1 numbers (the last word is kNoHit).
//
// What the triangles are. The map of a float vertex has an exact value, and these points are the scene: the judge's truth
// (validation/oracle/exact.h). triangle() and flattened() round them to floats, once per vertex, so that triangles that share a
// vertex in their mesh share it in the world.
//
// Several meshes that are not to be one are a scene, too: an instance of each, and place_of(hit.prim_id) tells which mesh was
// hit, and where.
//
// Copies share everything, and so does moving. The meshes' buffers are the caller's (core/buffer.h): they must not be written
// to any more. For a new frame, make new ones. Errors name the instance, counted from 1.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "libaccel/core/affine.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel {

struct Instance {
  std::uint32_t mesh = 0;  // which of the meshes
  Affine transform;        // from the mesh's space to the world
};

// Whether instances that place so many triangles, of meshes that have so many, are better kept apart than made one mesh: where
// that is large, and mostly copies. One mesh is 1.1 to 1.6 times as fast to trace, but takes as much more memory as there are
// copies, and as much longer to build: two seconds for a million triangles.
inline constexpr std::uint64_t kLargeMesh = 1 << 20, kMostlyCopies = 4;
constexpr bool are_better_apart(std::uint64_t placed, std::uint64_t of_meshes) {
  return placed >= kLargeMesh && placed > kMostlyCopies * of_meshes;
}

class InstancedMeshes {
 public:
  // No meshes and no instances.
  InstancedMeshes() : state_(std::make_shared<const Parts>()) {}
  InstancedMeshes(const InstancedMeshes&) = default;
  InstancedMeshes& operator=(const InstancedMeshes&) = default;

  // Errors: what validate() says about a mesh; an instance of a mesh that there is not; a map that inverse() refuses, or that
  // takes triangles in range out of it; more triangles than numbers.
  static Result<InstancedMeshes> make(std::vector<TriangleMesh> meshes, std::vector<Instance> instances);

  // The same meshes, placed otherwise: for frames in which instances move, come and go. O(instances), since nobody has changed
  // the meshes. Errors: of instances, as above.
  Result<InstancedMeshes> with_instances(std::vector<Instance> instances) const;

  std::span<const TriangleMesh> meshes() const { return state_->placed->meshes; }
  std::span<const Instance> instances() const { return state_->instances; }
  std::uint32_t first_prim(std::size_t instance) const { return state_->first_prims[instance]; }

  // The number of prim_ids: triangles, once for every instance.
  std::uint64_t size() const { return state_->size; }
  // What the meshes and the placements take.
  std::size_t size_bytes() const;
  bool is_better_apart() const;  // see above

  // Below, prim_ids are less than size(): not those of misses.
  //
  // The instance that a prim_id belongs to, and the number of the triangle in its mesh. O(log instances).
  struct Place {
    std::uint32_t instance, triangle;
  };
  Place place_of(std::uint32_t prim_id) const;

  // A triangle in the world, rounded to floats.
  Triangle triangle(std::uint32_t prim_id) const;

  // How far from triangle(prim_id), along any axis, a ray that starts nearby may meet it. With W_j the triangle's largest
  // distance from where the map takes zero: vertices are rounded, u |p|; the ray's origin is, in the instance's space, gamma(6)
  // sum_j |L_ij| W_j (core/affine.h); and the test there moves vertices by gamma(16) of their distance from the origin
  // (rays/offset_origin.h), which is at most 2 W. In the world |M| times both.
  double position_error(std::uint32_t prim_id) const;

  // flattened() of meshes and instances, with the same prim_ids. Made at the first call, and kept.
  Result<TriangleMesh> flattened() const;

 private:
  struct Flat;
  static std::shared_ptr<Flat> make_flat();
  struct Meshes {
    std::vector<TriangleMesh> meshes;
    std::vector<Aabb> bounds;  // of their triangles that are in range
  };
  struct Parts {
    std::shared_ptr<const Meshes> placed = std::make_shared<const Meshes>();
    std::vector<Instance> instances;
    std::vector<std::uint32_t> first_prims;
    std::uint64_t size = 0;
    std::shared_ptr<Flat> flat = make_flat();
  };
  explicit InstancedMeshes(std::shared_ptr<const Parts> state) : state_(std::move(state)) {}
  static Result<InstancedMeshes> place(std::shared_ptr<const Meshes> meshes, std::vector<Instance> instances);
  std::shared_ptr<const Parts> state_;
};

// All triangles in the world as one mesh: those of each instance, of a mesh that there is, follow those of the one before. The
// maps may be any, singular ones too. Errors: more triangles than a mesh may have, or than memory.
Result<TriangleMesh> flattened(std::span<const TriangleMesh> meshes, std::span<const Instance> instances);

// A vertex in the world, rounded to floats.
inline Vec3 placed(const Affine& transform, Vec3 vertex) { return transform_point(transform, Vec3d(vertex)).to_float(); }

}  // namespace accel
