// Ray against the two boxes of a Bvh2Node: the slab test of Kay and Kajiya 1986, robust in the sense of Ize 2013.
//
// A box is entered at the largest and left at the smallest of the ray's distances to its near and far planes. The distance to a
// plane, (plane - org) * inv_dir, has a relative error of at most gamma(3). The triangle test accepts hits on triangles whose vertices
// it has rounded, by at most gamma(5) of their distance from the origin along each axis (watertight.h), so a hit may lie that much
// outside of its box. Both errors, of the near and of the far plane, are covered by scaling the far distance by kFarScale =
// 1 + 2 gamma(8); the interval's end is scaled with it, so that a tie with the best hit is never culled.
//
// Zero direction components make inv_dir infinite: planes on one side give +inf or -inf, and a plane through the origin gives NaN,
// which the comparisons drop: the slab then does not restrict the ray, as it should. Directions too small for a finite reciprocal
// (denormals) use the largest float towards near planes and infinity towards far planes, which keeps both distances conservative.
#pragma once

#include <cstdint>
#include <limits>

#include "libaccel/core/float_bounds.h"
#include "libaccel/core/ray.h"
#include "libaccel/geometry/watertight_simd.h"
#include "libaccel/structure/bvh2.h"

namespace accel {

inline constexpr float kFarScale = 1.0f + 2.0f * gamma(8);

// What the slab test prepares once a ray.
struct RaySlabs {
  Vec3 org;
  Vec3 inv_near, inv_far;    // 1 / dir, for near and far planes
  std::uint32_t near_at[3];  // per axis: index in Bvh2Node::planes of child 0's near plane: 0, or 2 where dir is negative
  float t_min;

  ACCEL_HD static RaySlabs of(const Ray& ray, float t_min) {
    RaySlabs s;
    s.org = ray.org, s.t_min = t_min;
    for (int a = 0; a < 3; ++a) {
      const float inv = 1.0f / ray.dir[a];
      const float largest = std::numeric_limits<float>::max();
      const bool overflowed = ray.dir[a] != 0 && !(inv >= -largest && inv <= largest);
      s.inv_near[a] = overflowed ? (inv > 0 ? largest : -largest) : inv;
      s.inv_far[a] = inv;
      s.near_at[a] = inv < 0 ? 2u : 0u;
    }
    return s;
  }
};

// Which children the ray enters within [t_min, t_max], and where.
struct BoxPairHit {
  std::uint32_t mask;  // bit c: child c is entered
  float t_near0, t_near1;

  // The child to visit first, when both are entered: the nearer one, child 0 at equal distances.
  ACCEL_HD std::uint32_t nearer() const { return t_near1 < t_near0 ? 1u : 0u; }
  ACCEL_HD float farther_t() const { return t_near1 < t_near0 ? t_near0 : t_near1; }
};

// The portable version; the SIMD version below has the same bits, which a test compares.
ACCEL_HD BoxPairHit intersect_boxes_scalar(const Bvh2Node& node, const RaySlabs& ray, float t_max) {
  float t_near[2];
  std::uint32_t mask = 0;
  for (int c = 0; c < 2; ++c) {
    float enter = ray.t_min, leave = t_max;
    for (int a = 0; a < 3; ++a) {
      const float near_t = (node.planes[a][ray.near_at[a] + c] - ray.org[a]) * ray.inv_near[a];
      const float far_t = (node.planes[a][(ray.near_at[a] ^ 2u) + c] - ray.org[a]) * ray.inv_far[a];
      enter = max_of(near_t, enter);
      leave = min_of(far_t, leave);
    }
    t_near[c] = enter;
    mask |= enter <= leave * kFarScale ? 1u << c : 0u;
  }
  return {mask, t_near[0], t_near[1]};
}

#if ACCEL_SSE
// Lanes: near planes of children 0 and 1, far planes of children 0 and 1 with the sign changed, so that one max serves both.
ACCEL_HD BoxPairHit intersect_boxes_sse(const Bvh2Node& node, const RaySlabs& ray, float t_max) {
  const auto distances = [&](int a, float org, float inv_near, float inv_far) {
    __m128 planes = _mm_setzero_ps();
    planes = _mm_loadl_pi(planes, reinterpret_cast<const __m64*>(node.planes[a] + ray.near_at[a]));
    planes = _mm_loadh_pi(planes, reinterpret_cast<const __m64*>(node.planes[a] + (ray.near_at[a] ^ 2u)));
    return _mm_mul_ps(_mm_sub_ps(planes, _mm_set1_ps(org)), _mm_set_ps(-inv_far, -inv_far, inv_near, inv_near));
  };
  // maxps returns its second operand when one is NaN.
  __m128 t = _mm_set_ps(-t_max, -t_max, ray.t_min, ray.t_min);
  t = _mm_max_ps(distances(0, ray.org.x, ray.inv_near.x, ray.inv_far.x), t);
  t = _mm_max_ps(distances(1, ray.org.y, ray.inv_near.y, ray.inv_far.y), t);
  t = _mm_max_ps(distances(2, ray.org.z, ray.inv_near.z, ray.inv_far.z), t);
  const __m128 leave = _mm_mul_ps(_mm_movehl_ps(t, t), _mm_set1_ps(-kFarScale));
  const auto mask = static_cast<std::uint32_t>(_mm_movemask_ps(_mm_cmple_ps(t, leave))) & 3u;
  return {mask, _mm_cvtss_f32(t), _mm_cvtss_f32(_mm_shuffle_ps(t, t, _MM_SHUFFLE(1, 1, 1, 1)))};
}
#endif

ACCEL_HD BoxPairHit intersect_boxes(const Bvh2Node& node, const RaySlabs& ray, float t_max) {
#if ACCEL_SSE
  return intersect_boxes_sse(node, ray, t_max);
#else
  return intersect_boxes_scalar(node, ray, t_max);
#endif
}

}  // namespace accel
