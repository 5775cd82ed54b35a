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
// Sixteen aligned bytes: the first three lanes, and a word.
inline void store_with_word(void* out, Float4Scalar a, std::uint32_t word) {
  std::memcpy(out, a.v, 3 * sizeof(float));
  std::memcpy(static_cast<char*>(out) + 3 * sizeof(float), &word, sizeof(word));
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
#endif

inline Float4 load_point(const Vec3& p) {
  Float4 result;
  load_point(p, result);
  return result;
}

}  // namespace accel
