// Morton codes: positions whose bits are interleaved, so that sorting by code visits space along a Z-curve.
//
// Morton 1966; the bit tricks are the usual magic-mask spreads. Bit 0 of x is bit 0 of every code, then y, then z.
#pragma once

#include <cstdint>

#include "libaccel/core/aabb.h"
#include "libaccel/core/hd.h"

namespace accel {

// Bit i of the argument moves to bit 2 i.
ACCEL_HD std::uint64_t spread_2(std::uint32_t value) {
  std::uint64_t x = value;
  x = (x | x << 16) & 0x0000ffff0000ffffull;
  x = (x | x << 8) & 0x00ff00ff00ff00ffull;
  x = (x | x << 4) & 0x0f0f0f0f0f0f0f0full;
  x = (x | x << 2) & 0x3333333333333333ull;
  return (x | x << 1) & 0x5555555555555555ull;
}

// The inverse of spread_2; odd bits are ignored.
ACCEL_HD std::uint32_t gather_2(std::uint64_t x) {
  x &= 0x5555555555555555ull;
  x = (x | x >> 1) & 0x3333333333333333ull;
  x = (x | x >> 2) & 0x0f0f0f0f0f0f0f0full;
  x = (x | x >> 4) & 0x00ff00ff00ff00ffull;
  x = (x | x >> 8) & 0x0000ffff0000ffffull;
  return static_cast<std::uint32_t>(x | x >> 16);
}

// Bit i of the low 21 bits of the argument moves to bit 3 i.
ACCEL_HD std::uint64_t spread_3(std::uint32_t value) {
  std::uint64_t x = value & 0x1fffffu;
  x = (x | x << 32) & 0x001f00000000ffffull;
  x = (x | x << 16) & 0x001f0000ff0000ffull;
  x = (x | x << 8) & 0x100f00f00f00f00full;
  x = (x | x << 4) & 0x10c30c30c30c30c3ull;
  return (x | x << 2) & 0x1249249249249249ull;
}

ACCEL_HD std::uint64_t morton_2d(std::uint32_t x, std::uint32_t y) { return spread_2(x) | spread_2(y) << 1; }

// 63 bits of three coordinates of 21 bits.
ACCEL_HD std::uint64_t morton_3d(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return spread_3(x) | spread_3(y) << 1 | spread_3(z) << 2;
}

// Which of the 2^bits slices of [lo, hi] holds x. Points outside count to the nearest slice; NaN and flat intervals to slice 0.
ACCEL_HD std::uint32_t quantize(float x, float lo, float hi, int bits) {
  const double last = static_cast<double>((1u << bits) - 1u);
  const double slice = (static_cast<double>(x) - lo) / (static_cast<double>(hi) - lo) * (last + 1.0);
  if (!(slice > 0.0)) return 0;
  return static_cast<std::uint32_t>(slice < last ? slice : last);
}

// The code of a point in a box: 10 bits an axis in 30, or 21 bits an axis in 63.
ACCEL_HD std::uint32_t morton_30(Vec3 p, const Aabb& box) {
  return static_cast<std::uint32_t>(morton_3d(quantize(p.x, box.lo.x, box.hi.x, 10), quantize(p.y, box.lo.y, box.hi.y, 10),
                                              quantize(p.z, box.lo.z, box.hi.z, 10)));
}
ACCEL_HD std::uint64_t morton_63(Vec3 p, const Aabb& box) {
  return morton_3d(quantize(p.x, box.lo.x, box.hi.x, 21), quantize(p.y, box.lo.y, box.hi.y, 21),
                   quantize(p.z, box.lo.z, box.hi.z, 21));
}

}  // namespace accel
