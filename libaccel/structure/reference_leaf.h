// Leaves that refer to triangles instead of holding them: what structures use whose cells share triangles.
//
// The triangles are packed once each, in an array of slots; a leaf is a non-empty run of references to slots, the last of which
// is marked, and is named by the index of its first reference. As in a leaf stream (triangle_leaf.h) the end is marked instead
// of counted, so that a traversal carries one number. An empty leaf is named kEmptyLeaf and has no references.
#pragma once

#include <cstdint>

#include "libaccel/core/buffer.h"
#include "libaccel/core/result.h"
#include "libaccel/geometry/packed_triangle.h"

namespace accel {

inline constexpr std::uint32_t kLastReference = 0x80000000u;  // set in the last reference of a leaf
inline constexpr std::uint32_t kEmptyLeaf = 0xffffffffu;

ACCEL_HD std::uint32_t slot_of(std::uint32_t reference) { return reference & ~kLastReference; }
ACCEL_HD bool is_last(std::uint32_t reference) { return (reference & kLastReference) != 0; }

struct ReferenceLeavesView {
  const PackedTriangle* triangles = nullptr;  // by slot
  const std::uint32_t* references = nullptr;
};

struct ReferenceLeaves {
  Buffer<PackedTriangle> triangles;
  Buffer<std::uint32_t> references;

  template <class Self, class Visit>
  static void for_each_array(Self& self, Visit&& visit) {
    visit("triangles", self.triangles);
    visit("references", self.references);
  }
  ReferenceLeavesView view() const { return {triangles.data(), references.data()}; }
};

// Proves that slots, references and the triangles that they name are within range, and that the last leaf has an end: so a
// traversal that starts anywhere stays in the arrays. Which runs belong to which cells is the structure's to check.
Status validate(const ReferenceLeaves& leaves, std::uint64_t triangle_count);

}  // namespace accel
