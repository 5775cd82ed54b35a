// All hits of a ray, in order: for transparency, counting crossings, or looking behind what is in front.
//
//   for_each_hit(accel, ray, [&](const Hit& hit) {
//     light *= transmittance(hit.prim_id);
//     return light > 0;  // whether to go on
//   });
//
// Hits come by t, and by prim_id where t is the same; every triangle that the ray meets in its interval comes once, whatever
// the method. Single rays use the watertight test. For many rays at once, AnyAccel::k_nearest() has the k nearest of each.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "libaccel/registry/any_accel.h"

namespace accel {

// Hits are fetched some at a time, by a traversal for each lot: few at first, since the visitor may stop at any of them.
inline constexpr std::size_t kFirstHits = 8, kMostHits = 32;

// Calls visit(hit) for each hit until it returns false. Returns how many hits it was called with. The traversals are as many as
// there are doublings from kFirstHits to kMostHits, and one more for every kMostHits hits.
template <class Visit>
std::size_t for_each_hit(const AnyAccel& accel, const Ray& ray, Visit&& visit) {
  Hit hits[kMostHits];
  std::size_t visited = 0, wanted = kFirstHits;
  std::size_t found = accel.k_nearest(ray, std::span(hits, wanted));
  for (;;) {
    for (std::size_t i = 0; i < found; ++i) {
      ++visited;
      if (!visit(std::as_const(hits[i]))) return visited;
    }
    if (found < wanted) return visited;
    const Hit last = hits[found - 1];
    wanted = std::min(2 * wanted, kMostHits);
    found = accel.next_hits(ray, last, std::span(hits, wanted));
  }
}

}  // namespace accel
