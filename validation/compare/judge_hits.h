// The judge of multi-hit queries: what a list of a ray's hits is worth against the exact ones. See judge.h, whose bounds these
// are.
//
//   right   a hit on a triangle that the ray meets in its interval beyond doubt, with t within its bound.
//   edge    a hit that rounding may accept or not, with t within its bound: near an edge of its triangle, or near an end of the
//           ray's interval.
//   false   any other: the ray does not pass the triangle, or t is outside of its bound or of the ray's interval.
//   miss    hits that a watertight test must find are not there. A set of triangles must be hit as judge.h has it; here the set
//           is taken from those that are not in the list, so that for a ray through a shared edge one of the two triangles will
//           do, but no hit on another surface stands in for them.
//
// Hits must come by t, and by prim_id where t is the same; which makes each come once.
#pragma once

#include <cstdint>
#include <span>

#include "validation/compare/judge.h"

namespace accel::validation {

struct HitsVerdict {
  std::uint64_t right = 0, edge = 0, false_hit = 0;  // hits
  std::uint64_t miss = 0;                            // lists with something missing
  std::uint64_t disorder = 0;                        // lists out of order

  std::uint64_t failures() const { return false_hit + miss + disorder; }
  HitsVerdict& operator+=(const HitsVerdict& other);
};

// The list is said to be complete in front of t_end.
HitsVerdict judge_hits(const Judge& judge, const Ray& ray, std::span<const Hit> hits, double t_end);
HitsVerdict judge_hits(const Judge& judge, const Ray& ray, std::span<const Hit> hits);  // of all hits

}  // namespace accel::validation
