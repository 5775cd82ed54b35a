// Four floats for inner loops that work on boxes: a point or a corner of a box in the first three lanes, zero in the fourth.
//
// Float4Sse uses SSE2, which every x86-64 machine has; Float4Scalar is its portable twin with the same bits, which a test
// compares. The fourth lane is cleared on load: references keep an integer there, which as a float may be denormal and slow to
// multiply.
#pragma once

#include <cstdint>

#include "libaccel/core/aabb.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace accel {

struct Float4Scalar {
  float v[4];

  static Float4Scalar splat(float x) { return {{x, x, x, x}}; }
  static Float4Scalar of(const Vec3& p) { return {{p.x, p.y, p.z, 0.0f}}; }
  // `p` is 16-byte aligned, and 16 bytes can be read there.
  static Float4Scalar load_xyz(const Vec3& p) { return {{p.x, p.y, p.z, 0.0f}}; }
  Vec3 xyz() const { return {v[0], v[1], v[2]}; }
  // This with `value` in one lane.
  Float4Scalar with_lane(int lane, float value) const {
    Float4Scalar result = *this;
    result.v[lane] = value;
    return result;
  }
  Float4Scalar yzx() const { return {{v[1], v[2], v[0], v[3]}}; }
  float sum_xyz() const { return (v[0] + v[1]) + v[2]; }
  // Lane by lane, towards zero; the lanes are within the range of int32.
  void truncate_to(std::int32_t* out) const {
    for (int i = 0; i < 4; ++i) out[i] = static_cast<std::int32_t>(v[i]);
  }
};

template <class Operation>
inline Float4Scalar per_lane(Float4Scalar a, Float4Scalar b, Operation operation) {
  return {{operation(a.v[0], b.v[0]), operation(a.v[1], b.v[1]), operation(a.v[2], b.v[2]), operation(a.v[3], b.v[3])}};
}
inline Float4Scalar operator+(Float4Scalar a, Float4Scalar b) {
  return per_lane(a, b, [](float x, float y) { return x + y; });
}
inline Float4Scalar operator-(Float4Scalar a, Float4Scalar b) {
  return per_lane(a, b, [](float x, float y) { return x - y; });
}
inline Float4Scalar operator*(Float4Scalar a, Float4Scalar b) {
  return per_lane(a, b, [](float x, float y) { return x * y; });
}
// Where one is NaN, the second argument, as min_of(float, float).
inline Float4Scalar min_of(Float4Scalar a, Float4Scalar b) {
  return per_lane(a, b, [](float x, float y) { return min_of(x, y); });
}
inline Float4Scalar max_of(Float4Scalar a, Float4Scalar b) {
  return per_lane(a, b, [](float x, float y) { return max_of(x, y); });
}
// Whether a <= b in each of the first three lanes; false for NaN.
inline bool xyz_less_equal(Float4Scalar a, Float4Scalar b) { return a.v[0] <= b.v[0] && a.v[1] <= b.v[1] && a.v[2] <= b.v[2]; }

#if defined(__SSE2__)
struct Float4Sse {
  __m128 v;

  static Float4Sse splat(float x) { return {_mm_set1_ps(x)}; }
  static Float4Sse of(const Vec3& p) { return {_mm_set_ps(0.0f, p.z, p.y, p.x)}; }
  static Float4Sse load_xyz(const Vec3& p) {
    return {_mm_and_ps(_mm_load_ps(&p.x), _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1)))};
  }
  Float4Sse with_lane(int lane, float value) const {
    const __m128i here = _mm_cmpeq_epi32(_mm_set_epi32(3, 2, 1, 0), _mm_set1_epi32(lane));
    const __m128 mask = _mm_castsi128_ps(here);
    return {_mm_or_ps(_mm_and_ps(mask, _mm_set1_ps(value)), _mm_andnot_ps(mask, v))};
  }
  Vec3 xyz() const {
    alignas(16) float lanes[4];
    _mm_store_ps(lanes, v);
    return {lanes[0], lanes[1], lanes[2]};
  }
  Float4Sse yzx() const { return {_mm_shuffle_ps(v, v, _MM_SHUFFLE(3, 0, 2, 1))}; }
  float sum_xyz() const {
    const __m128 y = _mm_shuffle_ps(v, v, _MM_SHUFFLE(1, 1, 1, 1)), z = _mm_movehl_ps(v, v);
    return _mm_cvtss_f32(_mm_add_ss(_mm_add_ss(v, y), z));
  }
  void truncate_to(std::int32_t* out) const { _mm_storeu_si128(reinterpret_cast<__m128i*>(out), _mm_cvttps_epi32(v)); }
};
inline Float4Sse operator+(Float4Sse a, Float4Sse b) { return {_mm_add_ps(a.v, b.v)}; }
inline Float4Sse operator-(Float4Sse a, Float4Sse b) { return {_mm_sub_ps(a.v, b.v)}; }
inline Float4Sse operator*(Float4Sse a, Float4Sse b) { return {_mm_mul_ps(a.v, b.v)}; }
inline Float4Sse min_of(Float4Sse a, Float4Sse b) { return {_mm_min_ps(a.v, b.v)}; }
inline Float4Sse max_of(Float4Sse a, Float4Sse b) { return {_mm_max_ps(a.v, b.v)}; }
inline bool xyz_less_equal(Float4Sse a, Float4Sse b) { return (_mm_movemask_ps(_mm_cmple_ps(a.v, b.v)) & 7) == 7; }
using Float4 = Float4Sse;
#else
using Float4 = Float4Scalar;
#endif

// A box in Float4s: what Aabb is to Vec3.
struct Box4 {
  Float4 lo = Float4::splat(std::numeric_limits<float>::infinity());
  Float4 hi = Float4::splat(-std::numeric_limits<float>::infinity());

  bool empty() const { return !xyz_less_equal(lo, hi); }
  void extend(Float4 p) { lo = min_of(p, lo), hi = max_of(p, hi); }
  void extend(const Box4& b) { lo = min_of(b.lo, lo), hi = max_of(b.hi, hi); }
  // Half the surface area in units of 1 / scale^2; 0 for an empty box.
  float half_area(Float4 scale) const {
    const Float4 e = max_of(hi - lo, Float4::splat(0.0f)) * scale;
    return (e * e.yzx()).sum_xyz();
  }
  Aabb aabb() const { return {lo.xyz(), hi.xyz()}; }
  static Box4 of(const Aabb& b) { return {Float4::of(b.lo), Float4::of(b.hi)}; }
};

inline Box4 intersection(const Box4& a, const Box4& b) { return {max_of(a.lo, b.lo), min_of(a.hi, b.hi)}; }

}  // namespace accel
