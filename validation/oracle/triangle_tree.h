// A plain bounding-volume hierarchy that proposes candidates to the exact oracle.
//
// It must never lose a triangle, and it must share no code and no idea with the structures it helps to judge, lest they err
// together. So it is simple: binned SAH on the widest axis of the centroids, boxes in float (exact: they are minima and maxima
// of vertices), and slab tests in double that are padded outwards by more than they can be wrong.
//
// The slab test. (plane - org) * (1 / dir) has three rounded operations, so its relative error is below 4 * 2^-53; every entry
// is moved by 8 * 2^-53 of itself towards the outside. The interval of each axis then contains the exact one, and so does their
// intersection. A direction component of zero is decided by the sign of a difference, which floating point has right.
//
// With a padding p > 0 a box is inflated on all sides by p times its largest distance from the origin along an axis, and
// perhaps by a length that does not depend on the ray: this finds all triangles that a ray meets when vertices move by that
// much. It is how the judge asks what a single-precision test might see.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "libaccel/core/ray.h"
#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel::validation {

class TriangleTree {
 public:
  // A tree over those triangles of the mesh whose coordinates are all in range.
  explicit TriangleTree(const TriangleMesh& mesh);
  // A tree over all whose triangles in their meshes are in range.
  explicit TriangleTree(const InstancedMeshes& scene);

  // By how much boxes are inflated: by a share of their largest distance from the origin along an axis, and a length.
  struct Padding {
    double share = 0, length = 0;
  };

  // Calls visit(prim_id) for every triangle whose box, inflated by `padding`, meets the ray in [t_begin, t_end], and perhaps
  // for others; nearer boxes first. `visit` may lower t_end, and returns false to stop. The ray is traceable.
  template <class Visit>
  void visit(const Ray& ray, Padding padding, double t_begin, double& t_end, Visit&& visit) const;

 private:
  // An inner node's children are nodes_[first] and nodes_[first + 1]; a leaf holds prims_[first, first + count).
  struct Node {
    float lo[3], hi[3];
    std::uint32_t first, count;
  };
  struct Reference {
    float lo[3], hi[3];
    std::uint32_t prim_id;
  };
  class Builder;
  void build(std::vector<Reference>& references);

  struct Line {
    double org[3], dir[3], inv[3];
    Padding padding;
  };

  static constexpr int kStackSize = 128;  // Builder::kMaxDepth is less
  static constexpr double kSlabError = 8 * 0x1p-53;

  // Whether the line meets the inflated box in [t_begin, t_end]; `t_near` is not after the entry.
  static bool meets(const Node& node, const Line& line, double t_begin, double t_end, double& t_near);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> prims_;
};

inline bool TriangleTree::meets(const Node& node, const Line& line, double t_begin, double t_end, double& t_near) {
  double reach = 0;
  if (line.padding.share > 0) {
    for (int axis = 0; axis < 3; ++axis) {
      reach = std::max({reach, std::abs(node.lo[axis] - line.org[axis]), std::abs(node.hi[axis] - line.org[axis])});
    }
    reach = reach * line.padding.share + line.padding.length;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double lo = node.lo[axis] - line.org[axis] - reach, hi = node.hi[axis] - line.org[axis] + reach;
    if (line.dir[axis] == 0) {
      if (lo > 0 || hi < 0) return false;
      continue;
    }
    const double t0 = lo * line.inv[axis], t1 = hi * line.inv[axis];
    const double enter = std::min(t0, t1), leave = std::max(t0, t1);
    t_begin = std::max(t_begin, enter - kSlabError * std::abs(enter));
    t_end = std::min(t_end, leave + kSlabError * std::abs(leave));
  }
  t_near = t_begin;
  return t_begin <= t_end;
}

template <class Visit>
void TriangleTree::visit(const Ray& ray, Padding padding, double t_begin, double& t_end, Visit&& visit) const {
  if (nodes_.empty()) return;
  Line line;
  line.padding = padding;
  for (int axis = 0; axis < 3; ++axis) {
    line.org[axis] = ray.org[axis], line.dir[axis] = ray.dir[axis], line.inv[axis] = 1.0 / line.dir[axis];
  }

  struct Entry {
    std::uint32_t node;
    double t_near;
  };
  Entry stack[kStackSize];
  int size = 0;
  double t_near = 0;
  if (meets(nodes_[0], line, t_begin, t_end, t_near)) stack[size++] = {0, t_near};

  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.t_near > t_end) continue;
    const Node& node = nodes_[entry.node];
    for (std::uint32_t i = 0; i < node.count; ++i) {
      if (!visit(prims_[node.first + i])) return;
    }
    if (node.count > 0) continue;

    double near_a = 0, near_b = 0;
    const bool a = meets(nodes_[node.first], line, t_begin, t_end, near_a);
    const bool b = meets(nodes_[node.first + 1], line, t_begin, t_end, near_b);
    const bool a_first = !b || (a && near_a <= near_b);
    if (a && !a_first) stack[size++] = {node.first, near_a};
    if (b) stack[size++] = {node.first + 1, near_b};
    if (a && a_first) stack[size++] = {node.first, near_a};
  }
}

}  // namespace accel::validation
