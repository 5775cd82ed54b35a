// The step that collapses to wide trees make at every binary node: how many of the roots of a forest are best on the left.
//
// The function for SSE2 has the same bits as its portable twin, which a test compares.
#pragma once

#include <bit>
#include <cstdint>

#include "libaccel/structure/bvh8.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace accel {

// Costs carry a choice in their last three bits, which moves them by a millionth at most. They are not negative, and no sum of
// two that are possible comes near this; infinity with a choice in it would be no number.
inline constexpr float kImpossibleCost = 1e38f;
inline constexpr std::uint32_t kChoiceBits = 7;

inline std::uint32_t choice_of(float cost) { return std::bit_cast<std::uint32_t>(cost) & kChoiceBits; }
inline float with_choice(float cost, std::uint32_t choice) {
  return std::bit_cast<float>((std::bit_cast<std::uint32_t>(cost) & ~kChoiceBits) | choice);
}

// costs[r - 1], for r of 2 to 8: the least of left[k - 1] + right[r - k - 1] over k, with k for its choice; costs[0] is
// impossible. The arrays have eight costs each, and are aligned; the last of `left` and `right` is not used.
inline void choose_split_scalar(const float* left, const float* right, float* costs) {
  costs[0] = kImpossibleCost;
  for (std::uint32_t roots = 2; roots <= kBvh8Arity; ++roots) {
    float least = kImpossibleCost;
    for (std::uint32_t k = 1; k < roots; ++k) least = min_of(least, with_choice(left[k - 1] + right[roots - k - 1], k));
    costs[roots - 1] = least;
  }
}

#if defined(__SSE2__)
inline void choose_split_sse(const float* left, const float* right, float* costs) {
  // Of the right side, what numbers of roots of 1 to 4 and of 5 to 8 leave when k are on the left.
  const __m128 impossible = _mm_set1_ps(kImpossibleCost), r1 = _mm_load_ps(right), r5 = _mm_load_ps(right + 4);
  const auto join = [](__m128 a, __m128 b) { return _mm_shuffle_ps(a, b, _MM_SHUFFLE(1, 0, 3, 2)); };  // of halves
  const __m128 low_2 = _mm_movelh_ps(impossible, r1);
  const __m128 low_1 = _mm_move_ss(_mm_shuffle_ps(r1, r1, _MM_SHUFFLE(2, 1, 0, 0)), impossible);
  const __m128 low_3 = _mm_shuffle_ps(impossible, low_2, _MM_SHUFFLE(2, 0, 0, 0));
  const __m128 high_2 = join(r1, r5);
  const __m128 high_1 = _mm_shuffle_ps(high_2, r5, _MM_SHUFFLE(2, 1, 2, 1)),
               high_3 = _mm_shuffle_ps(r1, high_2, _MM_SHUFFLE(2, 1, 2, 1));

  const __m128i keep = _mm_set1_epi32(~static_cast<int>(kChoiceBits));
  const auto sum = [&](int k, __m128 rest) {
    const __m128i bits = _mm_castps_si128(_mm_add_ps(_mm_set1_ps(left[k - 1]), rest));
    return _mm_castsi128_ps(_mm_or_si128(_mm_and_si128(bits, keep), _mm_set1_epi32(k)));
  };
  const __m128 low = _mm_min_ps(_mm_min_ps(sum(1, low_1), sum(2, low_2)), sum(3, low_3));
  const __m128 high_a = _mm_min_ps(_mm_min_ps(sum(1, high_1), sum(2, high_2)), _mm_min_ps(sum(3, high_3), sum(4, r1)));
  const __m128 high_b = _mm_min_ps(_mm_min_ps(sum(5, low_1), sum(6, low_2)), sum(7, low_3));
  _mm_store_ps(costs, _mm_move_ss(low, impossible));
  _mm_store_ps(costs + 4, _mm_min_ps(high_a, high_b));
}
inline void choose_split(const float* left, const float* right, float* costs) { choose_split_sse(left, right, costs); }
#else
inline void choose_split(const float* left, const float* right, float* costs) { choose_split_scalar(left, right, costs); }
#endif

}  // namespace accel
