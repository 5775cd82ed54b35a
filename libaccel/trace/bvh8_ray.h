// A ray against the boxes of a node of eight children: the slab test of trace/box_pair.h, with the same guarantees
// (PaddedSlabs) or fewer (trace/slabs.h), in an order that eight lanes are through with sooner.
//
// The far planes' distances are not scaled by kFarScale: the reciprocals are, once a ray, and the interval's end, once a hit.
// That is one rounding more of each distance, so the factor covers gamma(9), not gamma(8).
//
// NaN, the distance to a plane through the origin along an axis that the ray does not move along, should not restrict the ray.
// Here it may set the restriction by another axis aside as well: such a ray may enter boxes that it need not.
#pragma once

#include "libaccel/structure/bvh8.h"
#include "libaccel/trace/box_pair.h"
#include "libaccel/trace/slabs.h"

namespace accel {

// The end of the interval, as distances to far planes are compared with it.
template <class Slabs = PaddedSlabs>
ACCEL_HD float scaled_end(float t) {
  return t * Slabs::kEndScale;
}

template <class Slabs = PaddedSlabs>
struct Bvh8Ray {
  Vec3 org;
  Vec3 inv_near, inv_far;  // 1 / dir, for near and far planes; those for far planes are scaled
  float t_min;
  std::uint32_t octant;  // bit a: the direction's component along axis a is negative

  ACCEL_HD static Bvh8Ray prepare(const Ray& ray, float t_min) {
    const ScalarBoxPairTest pair = ScalarBoxPairTest::prepare(ray, t_min);
    std::uint32_t octant = 0;
    for (int a = 0; a < 3; ++a) octant |= pair.near_at[a] != 0 ? 1u << a : 0u;
    return {pair.org, pair.inv_near, pair.inv_far * Slabs::kFarPlaneScale, t_min, octant};
  }

  // Whether the ray enters a child within [t_min, t_max], and where. `limit` is the scaled end.
  template <class Node>
  ACCEL_HD bool enters(const Node& node, std::uint32_t c, float limit, float& enter) const {
    if ((!Node::kAbsentAreFar || Slabs::kIsFused) && node.child[c] == kNoNode) return false;
    float nearer[3], farther[3];
    for (int a = 0; a < 3; ++a) {
      const std::uint32_t backwards = octant >> a & 1u;
      nearer[a] = plane_distance<Slabs>(node.plane(a, backwards, c), org[a], inv_near[a]);
      farther[a] = plane_distance<Slabs>(node.plane(a, backwards ^ 1u, c), org[a], inv_far[a]);
    }
    enter = max_of(max_of(nearer[1], nearer[2]), max_of(nearer[0], t_min));
    const float leave = min_of(min_of(farther[1], farther[2]), min_of(farther[0], limit));
    return enter <= leave;
  }
};

}  // namespace accel
