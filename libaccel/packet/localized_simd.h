// Localized intersection with the watertight test, with rays in SIMD lanes: the twin of intersect_leaves<Watertight>
// (packet/localized.h), the same operations on each ray, hence the same hits bit for bit. Compiled for every target of the
// machine's family, by Highway; the best that the machine has runs.
#pragma once

#include "libaccel/packet/localized.h"

namespace accel {

// hits[i] answers rays[i] for all rays of active packets; nothing else is written.
void intersect_watertight_simd(const LocalizedBatch& batch, Hit* hits);
void occlude_watertight_simd(const LocalizedBatch& batch, std::uint8_t* occluded);

// The name of the target that runs: "AVX3" and so on.
const char* packet_simd_target();

}  // namespace accel
