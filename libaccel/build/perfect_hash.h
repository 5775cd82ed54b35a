// A perfect hash of node keys (structure/node_hash.h): Binder and Keller 2016 [BK16], section 2.2.2; the method is that of
// Tarjan and Yao 1979, in buckets sorted by size as Fox et al. 1992 do it.
//
// Keys are sorted into buckets, buckets by decreasing size. Then all buckets of a size are placed at once: each looks for the
// first displacement, from a place of its own on, that moves all its keys to free slots. Where several find the same slot, the
// first of them in order gets it and the others look on. So what is done in parallel depends on the order of buckets alone, and
// the tables are the same for any number of threads. Buckets with one key need no slot: they hold the reference.
//
// Sizes follow from the number n of keys: D is the largest power of two that is at most n / 2, H the smallest odd number that
// is at least kSlotsPerKey n. About 8 n bytes.
//
// Retries. Two keys of one bucket that are equal mod H can never be separated: that is detected before anything is placed, and
// H grows by 2. (With wide keys and n^2 / 2 pairs of keys among D H places one is to be expected in every other table.) Where a
// bucket finds no displacement, H grows by a quarter and buckets are made with another multiplier; likewise where two keys are
// equal, which only prefixes can bring about. All this is bounded; the bound is reached with a probability below 2^-60.
//
// Deviation: [BK16] sizes both tables by the number of all nodes.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "libaccel/core/buffer.h"
#include "libaccel/core/result.h"
#include "libaccel/structure/node_hash.h"

namespace accel {

struct HashedNode {
  std::uint64_t key;  // of 32 or 64 bits
  NodeRef ref;
};

struct PerfectHash {
  Buffer<std::uint32_t> displacements;
  Buffer<NodeRef> slots;  // kNoNode where empty
  std::uint64_t multiplier = 0;
  std::uint32_t direct = 0;   // references in the displacement table
  std::uint32_t retries = 0;  // until keys could be separated
};

inline constexpr double kSlotsPerKey = 1.5;

// The multiplier of the n-th attempt: odd, and the first the golden ratio's.
std::uint64_t hash_multiplier(std::uint32_t attempt);

// Keys may depend on the multiplier: `keys_for` gives them, in any order, which does not matter. No tables where there are no
// keys. O(n) expected; parallel in the calling thread's arena; throws std::bad_alloc.
Result<PerfectHash> make_perfect_hash(const std::function<std::vector<HashedNode>(std::uint64_t multiplier)>& keys_for,
                                      bool narrow_keys);

}  // namespace accel
