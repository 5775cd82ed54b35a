// Splits the set of a kd-tree node at a plane: clipped ("perfect") splits that keep the event lists sorted.
//
// Wald and Havran 2006, sections 4.3 ("splicing and merging" in O(n)) and 5.3 (clipping to the cell): the events of references
// that stay on one side keep their order; references that the plane cuts are clipped to both cells, and their new events are
// sorted and merged. Clipping starts from the triangle each time, so that boxes are as tight as those of the exact part in the
// cell; a part that vanishes is dropped.
//
// Padding. A reference's box is that of the part of the triangle in the cell grown by `reach`, itself grown by `reach` and
// rounded outward, where reach is the pad of structure/padding.h and a slack for what is rounded before: a vertex of a clipped
// polygon (geometry/clip_triangle.h) by 8 u max|coordinate| for each of at most 7 cuts (u = 2^-53), and these sums by 2 u of
// about that. So a cell that is no farther than pad from a triangle meets the inside of its box: a triangle belongs into a cell
// unless box.lo >= cell.hi or box.hi <= cell.lo.
//
// Deterministic: children depend on the set and the plane alone. O(n + k log k) for k cut references.
#pragma once

#include "libaccel/build/kdtree_events.h"
#include "libaccel/build/kdtree_plane.h"
#include "libaccel/build/scratch_stack.h"
#include "libaccel/geometry/triangle_mesh.h"
#include "libaccel/structure/padding.h"

namespace accel {

class KdSplitter {
 public:
  // For references to triangles in `scene`, which is not empty.
  KdSplitter(const TriangleMesh& mesh, const Aabb& scene);

  // The set of all references, with a cell that contains them all; it lies in `memory`. The limit and the levels are the
  // caller's to set.
  KdSet root_set(const Reference* references, std::size_t count, ScratchStack& memory) const;

  // Splits `set`, whose levels are not 0, at a plane strictly within its cell. Children lie in the memory of their own;
  // `scratch` is as before when the function returns. The children's limits add up to the set's. Returns how many parts of cut
  // references were dropped, since the triangle itself does not come near the cell.
  std::size_t split(const KdSet& set, const KdPlane& plane, ScratchStack& scratch, ScratchStack& lower_memory,
                    ScratchStack& upper_memory, KdSet (&children)[2]) const;

 private:
  struct Straddler;
  struct Work;

  void classify(Work& work) const;
  void clip(Work& work) const;
  void distribute(Work& work) const;
  void distribute_events(Work& work, int axis, ScratchStack& scratch) const;
  void clip_straddler(const Work& work, std::uint32_t reference, Straddler& straddler) const;

  const TriangleMesh& mesh_;
  const Aabb scene_;
  double reach_[3];
};

}  // namespace accel
