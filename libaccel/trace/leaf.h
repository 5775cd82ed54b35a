// One primitive of a leaf stream: the intersect step that traversers share.
#pragma once

#include "libaccel/structure/triangle_leaf.h"
#include "libaccel/trace/traverser.h"

namespace accel {

// Tests the triangle at `quad` and moves `quad` to the next. Returns done when an any-hit query has found its hit, `after` when
// the leaf has ended, else intersect.
template <class Test, Query kQuery, class Observer>
ACCEL_HD Phase intersect_next(const LeafQuad* leaves, const Ray& ray, const typename Test::RayData& data, float t_min,
                              std::uint32_t& quad, Hit& hit, Phase after, Observer& observer) {
  const PackedTriangle& triangle = packed_triangle(leaves, quad);
  observer.load(Memory::triangle, &triangle, sizeof triangle);
  observer.triangle_test();
  Hit candidate;
  if (Test::intersect(triangle, ray, data, candidate)) {
    candidate.prim_id = triangle.prim_id();
    if (accept_hit(candidate, t_min, hit) && kQuery == Query::any) return Phase::done;
  }
  quad += kQuadsPerTriangle;
  observer.load(Memory::triangle, leaves + quad, sizeof(LeafQuad));
  return is_end_of_leaf(leaves, quad) ? after : Phase::intersect;
}

}  // namespace accel
