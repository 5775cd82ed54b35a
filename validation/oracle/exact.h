// The exact oracle: the closest hit of a ray over all triangles of a mesh or of instances, by exact arithmetic. The judge's
// last word. Triangles of instances are where their maps take the vertices exactly, not where floats would have them.
//
// Semantics, for floats taken at their exact values:
//   - a triangle is closed: its edges and vertices belong to it;
//   - a ray is the closed interval [max(t_min, 0), min(t_max, largest float)]: hits must have a t that a Hit can hold;
//   - a ray in the plane of a triangle (det = 0) does not hit it, a triangle without an area is never hit;
//   - rays that are not is_traceable() and triangles with a coordinate that is not in_range() hit nothing and are never hit.
//
// Ties are real: on a shared edge, and where surfaces lie in one plane, several triangles are hit at exactly the same t. The
// answer names all of them.
//
// Cost: tens of nanoseconds a candidate in double (exact_predicates.h), microseconds where only integers can tell; one exact
// evaluation a hit, for its t. Queries are const and may run on any number of threads. The mesh satisfies validate().
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "libaccel/core/ray.h"
#include "libaccel/geometry/triangle_source.h"
#include "validation/oracle/exact_predicates.h"
#include "validation/oracle/triangle_tree.h"

namespace accel::validation {

// The nearest hit: its t, rounded to double (relative error below 2^-51), and every triangle that is hit at exactly that t, in
// ascending order. A miss has no triangles and t = +infinity.
struct ExactHit {
  double t = std::numeric_limits<double>::infinity();
  std::vector<std::uint32_t> prims;

  bool valid() const { return !prims.empty(); }
  bool contains(std::uint32_t prim_id) const;
};

// Where the line of a ray meets the plane of a triangle: t, and u and v as in Hit; rounded to double.
struct ExactPoint {
  double t, u, v;
};

class ExactOracle {
 public:
  enum class Search : std::uint8_t {
    tree,  // candidates by TriangleTree
    all    // every triangle, for every ray: to test the former
  };

  explicit ExactOracle(const TriangleMesh& mesh, Search search = Search::tree);
  explicit ExactOracle(const InstancedMeshes& scene, Search search = Search::tree);

  ExactHit closest(const Ray& ray) const;
  bool any(const Ray& ray) const;

  // Where the line of the ray meets the plane of a triangle, if it does so in one point.
  std::optional<ExactPoint> point(const Ray& ray, std::uint32_t prim_id) const;

  // All triangles that the ray may meet before t_end when vertices move by up to `padding` times their largest distance from
  // the origin along an axis, and perhaps others; in ascending order. Of instances, when vertices move by that much in the
  // instance's space, where distances from what its map takes to zero count as well as those from the origin.
  std::vector<std::uint32_t> near(const Ray& ray, double padding, double t_end) const;

  // Whether a triangle can be hit at all: it has an area, and its coordinates are in range.
  bool can_be_hit(std::uint32_t prim_id) const;

  // A triangle in its own space, whether its coordinates there are in range, and the instance that it belongs to: null for
  // those of a mesh.
  Triangle local_triangle(std::uint32_t prim_id) const;
  bool is_known(std::uint32_t prim_id) const;
  const Instance* instance_of(std::uint32_t prim_id) const;
  std::uint32_t instance_number(std::uint32_t prim_id) const;  // 0 for those of a mesh

  // Triangles in the world, rounded to floats.
  TriangleSource triangles() const { return instances_ ? TriangleSource(*instances_) : TriangleSource(mesh_); }

 private:
  PlacedTriangle placed(std::uint32_t prim_id) const;
  template <class Visit>
  void visit(const Ray& ray, TriangleTree::Padding padding, double& t_end, Visit&& visit) const;

  // Both share the caller's buffers.
  TriangleMesh mesh_;
  std::optional<InstancedMeshes> instances_;
  Search search_;
  TriangleTree tree_;
  TriangleTree::Padding unit_padding_{1, 0};  // what a padding of 1 in instances' spaces may be in the world
};

}  // namespace accel::validation
