// The leaf stream: the triangles of all leaves, one leaf after the other, as structures that end in triangles store them.
//
// A leaf is a run of packed triangles (three quads of 16 bytes each) and one terminator quad. It is named by the index of its
// first quad. Aila and Laine 2009 mark the end of a leaf instead of counting it, which saves the count on its way through the
// traversal; Binder and Keller 2016, Fig. 5, use the words of the terminator quad for references to the uncle, grand-uncle and
// great-grand-uncle.
// The word that is a prim_id in a triangle's first quad is kEndOfLeaf in a terminator.
#pragma once

#include <cstdint>
#include <type_traits>

#include "libaccel/geometry/packed_triangle.h"

namespace accel {

inline constexpr std::uint32_t kEndOfLeaf = 0xffffffffu;
inline constexpr std::uint32_t kQuadsPerTriangle = 3;

// One quad of a leaf stream: a third of a packed triangle, or a terminator.
struct alignas(16) LeafQuad {
  std::uint32_t link[3];  // in a terminator: uncle, grand-uncle, great-grand-uncle, or zero
  std::uint32_t word;
};
static_assert(sizeof(LeafQuad) == 16 && std::is_trivially_copyable_v<LeafQuad>);
static_assert(sizeof(PackedTriangle) == kQuadsPerTriangle * sizeof(LeafQuad));

// The triangle that starts at a quad; the quad is not a terminator.
ACCEL_HD const PackedTriangle& packed_triangle(const LeafQuad* stream, std::uint32_t quad) {
  return *reinterpret_cast<const PackedTriangle*>(stream + quad);
}
ACCEL_HD bool is_end_of_leaf(const LeafQuad* stream, std::uint32_t quad) { return stream[quad].word == kEndOfLeaf; }

}  // namespace accel
