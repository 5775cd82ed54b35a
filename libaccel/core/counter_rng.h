// Random numbers by counter: element i of a seeded sequence is computed from i alone, so parallel loops are deterministic for
// any number of threads.
//
// SplitMix64 (Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number Generators"), with the seed, a stream and the
// element hashed into the start of the counter. 64 bits of state: good for test data, not for cryptography.
#pragma once

#include <cstdint>

namespace accel {

// The finalizer of SplitMix64: a bijection of 64-bit words that flips every output bit with probability 1/2.
constexpr std::uint64_t mix_bits(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

class CounterRng {
 public:
  // The sequence of one element. `stream` separates uses that share a seed.
  constexpr CounterRng(std::uint64_t seed, std::uint64_t element, std::uint64_t stream = 0)
      : state_(mix_bits(mix_bits(mix_bits(seed + kGolden) + stream + kGolden) + element)) {}

  constexpr std::uint64_t next_u64() { return mix_bits(state_ += kGolden); }

  // Uniform in [0, 1), 24 bits.
  constexpr float next_float() { return static_cast<float>(next_u64() >> 40) * 0x1p-24f; }
  // Uniform in [0, 1), 53 bits.
  constexpr double next_double() { return static_cast<double>(next_u64() >> 11) * 0x1p-53; }
  // Uniform in [lo, hi), up to rounding.
  constexpr float next_float(float lo, float hi) { return lo + (hi - lo) * next_float(); }
  // Uniform in 0 ... count - 1, with a bias below count / 2^32.
  constexpr std::uint32_t next_below(std::uint32_t count) {
    return static_cast<std::uint32_t>((next_u64() >> 32) * count >> 32);
  }

 private:
  static constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ull;
  std::uint64_t state_;
};

}  // namespace accel
