// Random trees whose perfect hash is made and proved: some of them in the unit tests, a million in bench/hash_sweep.
#pragma once

#include <cstdint>

#include "libaccel/core/result.h"
#include "libaccel/structure/bvh2.h"
#include "validation/stress/random_bvh2.h"

namespace accel::validation {

struct HashTrial {
  TreeShape shape;
  HashedKeys which;
  std::uint32_t depth;
  std::uint64_t keys;   // of the tree
  std::uint64_t bytes;  // of the tables
  Status status = Done{};
};

// Makes the tree of this number, of any shape, from one leaf to some thousand, and hashes the keys that may be looked up, or
// all. The status tells whether that succeeded and validate(), which looks up each of them, finds what it should.
HashTrial try_hash(std::uint64_t number);

}  // namespace accel::validation
