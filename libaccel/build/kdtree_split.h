// Splits the set of a kd-tree node at a plane: clipped ("perfect") splits that keep the event lists sorted.
//
// Wald and Havran 2006, sections 4.3 ("splicing and merging" in O(n)) and 5.3 (clipping to the cell): the events of references
// that stay on one side keep their order; references that the plane cuts are clipped to both cells (kdtree_clip.h), and their
// new events are sorted and merged. A part that vanishes is dropped.
//
// Deterministic: children depend on the set and the plane alone. O(n + k log k) for k cut references.
#pragma once

#include "libaccel/build/kdtree_clip.h"
#include "libaccel/build/kdtree_events.h"
#include "libaccel/build/kdtree_plane.h"
#include "libaccel/build/scratch_stack.h"

namespace accel {

class KdSplitter {
 public:
  // For references to triangles in `scene`, which is not empty.
  KdSplitter(const TriangleMesh& mesh, const Aabb& scene) : scene_(scene), clipper_(mesh, scene) {}

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
  void add_cut_events(const Work& work, int axis, ScratchStack& scratch) const;

  const Aabb scene_;
  const KdClipper clipper_;
};

}  // namespace accel
