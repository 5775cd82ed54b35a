// What packets are made of, for all who trace batches of rays as packets.
#pragma once

#include <cstdint>

#include "libaccel/core/aabb.h"
#include "libaccel/core/hd.h"

namespace accel {

// The most rays of a packet.
inline constexpr std::uint32_t kMaxPacketSize = 512;

struct PacketOptions {
  std::uint32_t max_size = 256;      // rays a packet, 1 to kMaxPacketSize; [GL10] section 5.1
  std::uint32_t min_size = 8;        // smaller packets are traced ray by ray
  std::uint32_t block_size = 32768;  // rays that are prepared together: some 40 bytes of memory each, a thread
  float cell_fraction = 0.004f;      // of the hash, as a share of the scene's diagonal; [GL10] section 5.1
  float max_width = 0.25f;           // of a frustum, as a share of the scene's longest side
  float budget = 0.5f;               // pairs in the queue per ray of a frustum
};

// What the frustum of so many rays may have in the queue; nothing for budgets that are negative or no number.
ACCEL_HD std::uint32_t budget_for(float budget, std::uint32_t rays) {
  constexpr float kMost = 4294967040.0f;  // the largest float below 2^32
  const float pairs = budget * static_cast<float>(rays);
  return pairs > 0 ? static_cast<std::uint32_t>(min_of(pairs, kMost)) : 0;
}

}  // namespace accel
