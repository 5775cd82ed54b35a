// Ray against the two boxes of a Bvh2Node: the slab test of Kay and Kajiya 1986, robust in the sense of Ize 2013.
//
// A box is entered at the largest and left at the smallest of the ray's distances to its near and far planes. The distance to a
// plane, (plane - org) * inv_dir, has a relative error of at most gamma(3). The triangle test accepts hits on triangles whose
// vertices it has rounded, by at most gamma(5) of their distance from the origin along each axis (watertight.h), so a hit may
// lie that much outside of its box. Both errors, of the near and of the far plane, are covered by scaling the far distance by
// kFarScale = 1 + 2 gamma(8); the interval's end is scaled with it, so that a tie with the best hit is not culled either. Not
// covered are triangles seen edge-on, whose t may lie anywhere between their vertices, and tests without a bound
// (moeller_trumbore.h): such a hit may be nearer than its box.
//
// Zero direction components make inv_dir infinite: planes on one side give +inf or -inf, and a plane through the origin gives
// NaN, which the comparisons drop: the slab then does not restrict the ray, as it should. Directions too small for a finite
// reciprocal (denormals) use the largest float towards near planes and infinity towards far planes, which keeps both distances
// conservative.
#pragma once

#include <cstdint>
#include <limits>

#include "libaccel/core/float_bounds.h"
#include "libaccel/core/ray.h"
#include "libaccel/geometry/watertight_simd.h"
#include "libaccel/structure/bvh2.h"

namespace accel {

inline constexpr float kFarScale = 1.0f + 2.0f * gamma(8);

// Which children the ray enters within [t_min, t_max], and where.
struct BoxPairHit {
  std::uint32_t mask;  // bit c: child c is entered
  float t_near0, t_near1;
  float t_far0, t_far1;  // where it leaves them, at the interval's end at the latest, not scaled
};

// The portable version: what it prepares once a ray, and the test.
struct ScalarBoxPairTest {
  Vec3 org;
  Vec3 inv_near, inv_far;    // 1 / dir, for near and far planes
  std::uint32_t near_at[3];  // per axis: index in Bvh2Node::planes of child 0's near plane: 0, or 2 where dir is negative
  float t_min;

  // A row of Bvh2Node::planes.
  struct alignas(16) Planes {
    float at[4];
  };

  ACCEL_HD static ScalarBoxPairTest prepare(const Ray& ray, float t_min) {
    ScalarBoxPairTest test;
    test.org = ray.org, test.t_min = t_min;
    for (int a = 0; a < 3; ++a) {
      const float inv = 1.0f / ray.dir[a];
      const float largest = std::numeric_limits<float>::max();
      const bool overflowed = ray.dir[a] != 0 && !(inv >= -largest && inv <= largest);
      test.inv_near[a] = overflowed ? (inv > 0 ? largest : -largest) : inv;
      test.inv_far[a] = inv;
      test.near_at[a] = inv < 0 ? 2u : 0u;
    }
    return test;
  }

  ACCEL_HD BoxPairHit intersect(const Bvh2Node& node, float t_max) const {
    float enter[2] = {t_min, t_min}, leave[2] = {t_max, t_max};
    for (int a = 0; a < 3; ++a) {
      const Planes planes = load_16_bytes(reinterpret_cast<const Planes&>(node.planes[a]));
      const bool backwards = near_at[a] != 0;
      for (int c = 0; c < 2; ++c) {
        const float near_t = ((backwards ? planes.at[2 + c] : planes.at[c]) - org[a]) * inv_near[a];
        const float far_t = ((backwards ? planes.at[c] : planes.at[2 + c]) - org[a]) * inv_far[a];
        enter[c] = max_of(near_t, enter[c]);
        leave[c] = min_of(far_t, leave[c]);
      }
    }
    const std::uint32_t mask = (enter[0] <= leave[0] * kFarScale ? 1u : 0u) | (enter[1] <= leave[1] * kFarScale ? 2u : 0u);
    return {mask, enter[0], enter[1], leave[0], leave[1]};
  }
};

#if ACCEL_SSE
// The same operations, hence the same bits, in four lanes: near planes of children 0 and 1, far planes of children 0 and 1 with
// the sign changed, so that one max serves both. maxps returns its second operand when one is NaN.
struct SseBoxPairTest {
  __m128 org[3], inv[3];
  std::uint32_t near_at[3];
  float t_min;

  static SseBoxPairTest prepare(const Ray& ray, float t_min) {
    const ScalarBoxPairTest scalar = ScalarBoxPairTest::prepare(ray, t_min);
    SseBoxPairTest test;
    for (int a = 0; a < 3; ++a) {
      test.org[a] = _mm_set1_ps(scalar.org[a]);
      test.inv[a] = _mm_set_ps(-scalar.inv_far[a], -scalar.inv_far[a], scalar.inv_near[a], scalar.inv_near[a]);
      test.near_at[a] = scalar.near_at[a];
    }
    test.t_min = t_min;
    return test;
  }

  ACCEL_HD BoxPairHit intersect(const Bvh2Node& node, float t_max) const {
    __m128 t = _mm_set_ps(-t_max, -t_max, t_min, t_min);
    for (int a = 0; a < 3; ++a) t = _mm_max_ps(distances(node, a), t);
    const __m128 leave = _mm_mul_ps(_mm_movehl_ps(t, t), _mm_set1_ps(-kFarScale));
    const auto mask = static_cast<std::uint32_t>(_mm_movemask_ps(_mm_cmple_ps(t, leave))) & 3u;
    return {mask, _mm_cvtss_f32(t), _mm_cvtss_f32(_mm_shuffle_ps(t, t, _MM_SHUFFLE(1, 1, 1, 1))),
            -_mm_cvtss_f32(_mm_shuffle_ps(t, t, _MM_SHUFFLE(2, 2, 2, 2))),
            -_mm_cvtss_f32(_mm_shuffle_ps(t, t, _MM_SHUFFLE(3, 3, 3, 3)))};
  }

 private:
  ACCEL_HD __m128 distances(const Bvh2Node& node, int a) const {
    // By types that may alias floats, as double may not.
    __m128 planes = _mm_castsi128_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(node.planes[a] + near_at[a])));
    planes = _mm_loadh_pi(planes, reinterpret_cast<const __m64*>(node.planes[a] + (near_at[a] ^ 2u)));
    return _mm_mul_ps(_mm_sub_ps(planes, org[a]), inv[a]);
  }
};
using BoxPairTest = SseBoxPairTest;
#else
using BoxPairTest = ScalarBoxPairTest;
#endif

}  // namespace accel
