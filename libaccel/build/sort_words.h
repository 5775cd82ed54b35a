// A parallel radix sort of words by their upper bits: for keys that leave room for a number below them.
//
// By digits of 11 bits, the least first; each part of the array counts its digits and then moves its words to where they go.
// Stable, and the same for any number of threads and parts. O(n) for each digit in which words differ. May throw
// std::bad_alloc. Sizes are below 2^32.
#pragma once

#include <cstddef>
#include <cstdint>

namespace accel {

inline constexpr int kWordDigitBits = 11;

// Sorts by bits [first_bit, 64), in whole digits from first_bit on. Returns where the sorted words are: `words`, or `other`,
// which has room for as many.
std::uint64_t* sort_words(std::uint64_t* words, std::uint64_t* other, std::size_t n, int first_bit);

}  // namespace accel
