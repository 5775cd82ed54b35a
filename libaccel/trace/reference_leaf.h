// One primitive of a leaf of references: the intersect step of traversers whose leaves share triangles.
#pragma once

#include "libaccel/structure/reference_leaf.h"
#include "libaccel/trace/mailbox.h"
#include "libaccel/trace/traverser.h"

namespace accel {

// Tests the triangle that `reference` names, unless the mailbox knows it, and moves on to the next reference. Returns done when
// an any-hit query has found its hit, `after` when the leaf has ended, else intersect.
template <class Test, Query kQuery, class Mailbox, class Observer>
ACCEL_HD Phase intersect_next(const ReferenceLeavesView& leaves, const Ray& ray, const typename Test::RayData& data,
                              float t_min, std::uint32_t& reference, Mailbox& mailbox, Hit& hit, Phase after,
                              Observer& observer) {
  const std::uint32_t word = leaves.references[reference++];
  observer.load(Memory::triangle, leaves.references + reference - 1, sizeof word);
  const Phase next = is_last(word) ? after : Phase::intersect;
  if (mailbox.remember(slot_of(word))) return next;

  const PackedTriangle& triangle = leaves.triangles[slot_of(word)];
  observer.load(Memory::triangle, &triangle, sizeof triangle);
  observer.triangle_test();
  Hit candidate;
  if (Test::intersect(triangle, ray, data, candidate)) {
    candidate.prim_id = triangle.prim_id();
    if (accept_hit(candidate, t_min, hit) && kQuery == Query::any) return Phase::done;
  }
  return next;
}

// Without a mailbox.
template <class Test, Query kQuery, class Observer>
ACCEL_HD Phase intersect_next(const ReferenceLeavesView& leaves, const Ray& ray, const typename Test::RayData& data,
                              float t_min, std::uint32_t& reference, Hit& hit, Phase after, Observer& observer) {
  NoMailbox none;
  return intersect_next<Test, kQuery>(leaves, ray, data, t_min, reference, none, hit, after, observer);
}

}  // namespace accel
