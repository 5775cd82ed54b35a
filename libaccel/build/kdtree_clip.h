// The part of a triangle that a cell of a kd-tree has to know, as a padded box: "perfect" splits, Wald and Havran 2006, "On
// building fast kd-trees for ray tracing, and on doing that in O(N log N)", section 5.3.
//
// Clipping starts from the triangle each time, so that boxes are as tight as those of the exact part in the cell.
//
// Padding. A box is that of the part of the triangle in the cell grown by `reach`, itself grown by `reach` and rounded outward,
// where reach is the pad of structure/padding.h and a slack for what is rounded before: a vertex of a clipped polygon
// (geometry/clip_triangle.h) by 8 u max|coordinate| for each of at most 7 cuts (u = 2^-53), and these sums by 2 u of about
// that. So a cell that is no farther than pad from a triangle meets the inside of its box: a triangle belongs into a cell
// unless box.lo >= cell.hi or box.hi <= cell.lo.
#pragma once

#include "libaccel/build/kdtree_plane.h"
#include "libaccel/build/references.h"
#include "libaccel/structure/padding.h"

namespace accel {

class KdClipper {
 public:
  // For triangles of a mesh in `scene`, which is not empty.
  KdClipper(const TriangleMesh& mesh, const Aabb& scene);

  // The box of what is not cut, and the root's cell, from its bounds.
  Aabb whole(const Aabb& bounds) const { return padded(bounds, {reach_[0], reach_[1], reach_[2]}); }

  // The parts of a triangle of `cell` below and above a plane in it; `side` is kNowhere where the cell on that side need not
  // know the triangle.
  static constexpr std::uint32_t kNowhere = 0xffffffffu;
  void cut(std::uint32_t prim_id, const Aabb& cell, const KdPlane& plane, Reference (&parts)[2]) const;

 private:
  const TriangleMesh& mesh_;
  double reach_[3];
};

}  // namespace accel
