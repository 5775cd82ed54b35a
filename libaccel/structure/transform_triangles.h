// Replaces the packed triangles of a structure by what a triangle test precomputes from them (geometry/baldwin_weber.h).
//
// For structures whose leaves hold or refer to packed triangles: leaf streams (triangle_leaf.h) and slots (reference_leaf.h).
#pragma once

#include <concepts>
#include <cstdint>

#include "libaccel/structure/reference_leaf.h"
#include "libaccel/structure/triangle_leaf.h"

namespace accel {

// A copy of the triangles, each transformed. May throw std::bad_alloc.
template <class Transform>
ReferenceLeaves transformed(const ReferenceLeaves& leaves, const Transform& transform) {
  ReferenceLeaves result{Buffer<PackedTriangle>(leaves.triangles.size()), leaves.references};
  for (std::size_t i = 0; i < leaves.triangles.size(); ++i) result.triangles[i] = transform(leaves.triangles[i]);
  return result;
}

// A stream is read from its start: each quad begins a triangle or ends a leaf.
template <class Transform>
Buffer<LeafQuad> transformed(const Buffer<LeafQuad>& leaves, const Transform& transform) {
  Buffer<LeafQuad> result = Buffer<LeafQuad>::copy_of(leaves.span());
  for (std::uint32_t quad = 0; quad < leaves.size();) {
    if (is_end_of_leaf(leaves.data(), quad)) {
      ++quad;
      continue;
    }
    reinterpret_cast<PackedTriangle&>(result[quad]) = transform(packed_triangle(leaves.data(), quad));
    quad += kQuadsPerTriangle;
  }
  return result;
}

template <class Structure>
concept HoldsPackedTriangles =
    std::same_as<decltype(Structure::leaves), Buffer<LeafQuad>> || std::same_as<decltype(Structure::leaves), ReferenceLeaves>;

// A copy of the structure that shares all other arrays.
template <HoldsPackedTriangles Structure, class Transform>
Structure with_transformed_triangles(const Structure& structure, const Transform& transform) {
  Structure result = structure;
  result.leaves = transformed(structure.leaves, transform);
  return result;
}

}  // namespace accel
