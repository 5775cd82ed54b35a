// How Float4s (core/float4_simd.h) come from memory and go there: points of twelve bytes, and corners of boxes with a word of
// the caller's behind them.
//
// For loops in which this is most of the work: what is written in parts and read at once waits until it is in the cache.
// Overloads for Float4Scalar are the portable twins.
#pragma once

#include <cstdint>
#include <cstring>

#include "libaccel/core/float4_simd.h"

namespace accel {

inline void load_point(const Vec3& p, Float4Scalar& out) { out = Float4Scalar::of(p); }
// Four floats, at any address.
inline void store(float* out, Float4Scalar a) { std::memcpy(out, a.v, sizeof(a.v)); }
// Sixteen aligned bytes: the first three lanes, and a word.
inline void store_with_word(void* out, Float4Scalar a, std::uint32_t word) {
  std::memcpy(out, a.v, 3 * sizeof(float));
  std::memcpy(static_cast<char*>(out) + 3 * sizeof(float), &word, sizeof(word));
}

// The first three lanes of four, by lane: from points to coordinates.
inline void transpose(const Float4Scalar in[4], Float4Scalar out[3]) {
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < 4; ++i) out[a].v[i] = in[i].v[a];
}

// Half the surface areas of four boxes that are not empty, as Box4::half_area() has them.
inline void half_areas(const Float4Scalar lo[4], const Float4Scalar hi[4], Float4Scalar scale, float* out) {
  for (int i = 0; i < 4; ++i) {
    const Float4Scalar e = (hi[i] - lo[i]) * scale;
    out[i] = (e * e.yzx()).sum_xyz();
  }
}

#if defined(__SSE2__)
inline void load_point(const Vec3& p, Float4Sse& out) {
  const __m128 xy = _mm_castsi128_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(&p.x)));
  out = {_mm_movelh_ps(xy, _mm_load_ss(&p.z))};
}
inline void store_with_word(void* out, Float4Sse a, std::uint32_t word) {
  const __m128 words = _mm_castsi128_ps(_mm_set1_epi32(static_cast<int>(word)));
  _mm_store_ps(static_cast<float*>(out), _mm_movelh_ps(a.v, _mm_unpackhi_ps(a.v, words)));
}
inline void store(float* out, Float4Sse a) { _mm_storeu_ps(out, a.v); }
inline void transpose(const Float4Sse in[4], Float4Sse out[3]) {
  const __m128 ab = _mm_unpacklo_ps(in[0].v, in[1].v), cd = _mm_unpacklo_ps(in[2].v, in[3].v);
  out[0] = {_mm_movelh_ps(ab, cd)}, out[1] = {_mm_movehl_ps(cd, ab)};
  out[2] = {_mm_movelh_ps(_mm_unpackhi_ps(in[0].v, in[1].v), _mm_unpackhi_ps(in[2].v, in[3].v))};
}
inline void half_areas(const Float4Sse lo[4], const Float4Sse hi[4], Float4Sse scale, float* out) {
  Float4Sse extent[4], e[3];
  for (int i = 0; i < 4; ++i) extent[i] = (hi[i] - lo[i]) * scale;
  transpose(extent, e);
  store(out, (e[0] * e[1] + e[1] * e[2]) + e[2] * e[0]);
}
#endif

inline Float4 load_point(const Vec3& p) {
  Float4 result;
  load_point(p, result);
  return result;
}

}  // namespace accel
