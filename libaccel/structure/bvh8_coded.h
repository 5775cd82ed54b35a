// Nodes of a Bvh8 whose boxes are codes of 8 or 16 bits: less to fetch, larger boxes.
//
// Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.1. A node
// has a frame: the lower corner of all its children's boxes, and a power of two for each axis; a plane is
//
//     origin + value(code) * 2^exponent
//
// whose product is exact, so that everybody decodes the same float, fused or not. Codes are rounded outward against exactly
// that float: a decoded box contains the box that it stands for, whatever the sum's rounding did. So coding may cost time,
// never a hit.
//
// Codings. A byte is a number from 0 to 255. A half is the bits of a 16-bit float of IEEE 754 in [0, 1]: finer near the frame's
// lower corner, and 2^-11 of its size elsewhere; denormals are left out, since machines take long over them.
//
// Deviations from the paper: references and the order of children (structure/bvh8.h) are stored in full.
#pragma once

#include <bit>
#include <cstdint>

#include "libaccel/structure/bvh8.h"

namespace accel {

struct ByteCoding {
  using Code = std::uint8_t;
  static constexpr const char* kKind = "bvh8-byte";
  static constexpr Code kMost = 255;

  ACCEL_HD static float value(Code code) { return static_cast<float>(code); }
  static Code next(Code code) { return static_cast<Code>(code + 1); }
  static Code previous(Code code) { return static_cast<Code>(code - 1); }
  // The code of some value near x, which lies in [0, value(kMost)].
  static Code near(double x) { return static_cast<Code>(x); }
};

struct HalfCoding {
  using Code = std::uint16_t;
  static constexpr const char* kKind = "bvh8-half";
  static constexpr Code kMost = 0x3c00;           // 1
  static constexpr Code kSmallestNormal = 0x400;  // 2^-14

  // Exponents of halves count from 15, those of floats from 127.
  ACCEL_HD static float value(Code code) {
    return __builtin_bit_cast(float, static_cast<std::uint32_t>(code) << 13) * 0x1p112f;
  }
  static Code next(Code code) { return code < kSmallestNormal ? kSmallestNormal : static_cast<Code>(code + 1); }
  static Code previous(Code code) { return code <= kSmallestNormal ? Code{0} : static_cast<Code>(code - 1); }
  static Code near(double x) {
    if (x < 0x1p-14) return 0;
    return static_cast<Code>((std::bit_cast<std::uint32_t>(static_cast<float>(x)) >> 13) - (112u << 10));
  }
};

template <class CodingType>
struct alignas(64) CodedBvh8Node {
  using Block = TriangleBlock;
  using Coding = CodingType;
  using Code = typename Coding::Code;
  static constexpr const char* kKind = Coding::kKind;
  static constexpr bool kIsExact = false;
  static constexpr bool kAbsentAreFar = false;

  NodeRef child[kBvh8Arity];        // as in Bvh8Node; first, where vectors of them are aligned
  std::uint32_t order[kBvh8Arity];  // likewise
  float origin[3];
  std::int8_t exponent[3];  // at least kLeastExponent
  std::int8_t unused;       // zero
  Code planes[3][2][kBvh8Arity];

  static constexpr int kLeastExponent = -126, kMostExponent = 127;  // of a power of two that is a normal float

  ACCEL_HD float scale(int axis) const {
    return __builtin_bit_cast(float, static_cast<std::uint32_t>(exponent[axis] + 127) << 23);
  }
  ACCEL_HD float decode(int axis, Code code) const { return origin[axis] + Coding::value(code) * scale(axis); }
  ACCEL_HD float plane(int axis, std::uint32_t side, std::uint32_t c) const { return decode(axis, planes[axis][side][c]); }
  ACCEL_HD Aabb bounds(std::uint32_t c) const { return child_bounds(*this, c); }
  ACCEL_HD std::uint32_t ordered(std::uint32_t i, std::uint32_t octant) const { return ordered_child(*this, i, octant); }
  ACCEL_HD bool is_absent(std::uint32_t c) const {
    for (int a = 0; a < 3; ++a)
      if (!(planes[a][0][c] == Coding::kMost && planes[a][1][c] == 0)) return false;
    return true;
  }
};

using ByteBvh8Node = CodedBvh8Node<ByteCoding>;
using HalfBvh8Node = CodedBvh8Node<HalfCoding>;

// Of the layout with the least memory: nodes of bytes, above leaves that name vertices.
struct CompactBvh8Node : ByteBvh8Node {
  using Block = IndexedBlock;
  static constexpr const char* kKind = "bvh8-compact";
};
static_assert(sizeof(ByteBvh8Node) == 128 && sizeof(HalfBvh8Node) == 192 && sizeof(CompactBvh8Node) == 128);

using Bvh8Byte = Bvh8Of<ByteBvh8Node>;
using Bvh8Half = Bvh8Of<HalfBvh8Node>;
using Bvh8Compact = Bvh8Of<CompactBvh8Node>;

}  // namespace accel
