// Remembers triangles that a ray has been tested against, for structures whose cells share triangles.
//
// Amanatides and Woo 1987, "A Fast Voxel Traversal Algorithm for Ray Tracing", and Arnaldi, Priol and Bouatouch 1987 keep the
// number of the last ray with each triangle. Deviation: rays that share memory cannot write to triangles, so the ray keeps the
// last few slots that it was tested against (inverse mailboxing: Shevtsov, Soupikov and Kapustin 2007, "Ray-Triangle
// Intersection Algorithm for Modern CPU Architectures").
//
// Skipping a triangle changes no hit: a test looks at the whole line of the ray, and what accept_hit() refused once it refuses
// for ever, since the interval only shrinks. What is forgotten is tested again.
#pragma once

#include <cstdint>

#include "libaccel/core/hd.h"

namespace accel {

// Remembers nothing and compiles to nothing.
struct NoMailbox {
  ACCEL_HD void clear() {}
  ACCEL_HD bool remember(std::uint32_t) { return false; }
};

// The last kSize slots. Named entries that move along, and no ring with an index: they stay in registers.
template <int kSize>
struct Mailbox {
  static constexpr std::uint32_t kNoSlot = 0xffffffffu;
  std::uint32_t slots[kSize];

  ACCEL_HD void clear() {
    for (int i = 0; i < kSize; ++i) slots[i] = kNoSlot;
  }

  // Whether the slot is remembered; if it is not, it will be, in place of the oldest.
  ACCEL_HD bool remember(std::uint32_t slot) {
    bool found = false;
    for (int i = 0; i < kSize; ++i) found |= slots[i] == slot;
    if (found) return true;
    for (int i = kSize - 1; i > 0; --i) slots[i] = slots[i - 1];
    slots[0] = slot;
    return false;
  }
};

}  // namespace accel
