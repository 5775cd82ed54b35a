// No hierarchy: all triangles in one leaf. The structure of the brute-force method, against which every other is tested.
#pragma once

#include "libaccel/structure/arrays.h"
#include "libaccel/structure/triangle_leaf.h"

namespace accel {

struct TriangleListView {
  const LeafQuad* leaves = nullptr;  // one leaf, at quad 0
};

struct TriangleList {
  static constexpr const char* kName = "list";
  using View = TriangleListView;

  Buffer<LeafQuad> leaves;

  template <class Self, class Visit>
  static void for_each_array(Self& self, Visit&& visit) {
    visit("leaves", self.leaves);
  }
  std::size_t size_bytes() const { return bytes_of_arrays(*this); }
  TriangleListView view() const { return {leaves.data()}; }
};

// As validate(const Bvh2&, ...).
Status validate(const TriangleList& list, std::uint64_t triangle_count);

}  // namespace accel
