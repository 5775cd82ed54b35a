// One primitive of a leaf of references: the intersect step of traversers whose leaves share triangles.
#pragma once

#include "libaccel/structure/reference_leaf.h"
#include "libaccel/trace/traverser.h"

namespace accel {

// Tests the triangle that `reference` names and moves on to the next reference. Returns done when an any-hit query has found
// its hit, `after` when the leaf has ended, else intersect.
template <class Test, Query kQuery, class Observer>
ACCEL_HD Phase intersect_next(const ReferenceLeavesView& leaves, const Ray& ray, const typename Test::RayData& data,
                              float t_min, std::uint32_t& reference, Hit& hit, Phase after, Observer& observer) {
  const std::uint32_t word = leaves.references[reference++];
  observer.load(Memory::triangle, leaves.references + reference - 1, sizeof word);
  const PackedTriangle& triangle = leaves.triangles[slot_of(word)];
  observer.load(Memory::triangle, &triangle, sizeof triangle);
  observer.triangle_test();
  Hit candidate;
  if (Test::intersect(triangle, ray, data, candidate)) {
    candidate.prim_id = triangle.prim_id();
    if (accept_hit(candidate, t_min, hit) && kQuery == Query::any) return Phase::done;
  }
  return is_last(word) ? after : Phase::intersect;
}

}  // namespace accel
