// The uniform grid: equal cells, each with the triangles that reach into it.
//
// Fujimoto, Tanaka and Iwata 1986, "ARTS: Accelerated Ray-Tracing System"; Purcell et al. 2002, "Ray Tracing on Programmable
// Graphics Hardware", whose grid is the baseline of Foley and Sugerman 2005 [FS05]. Deviation: the triangles of a cell are a
// marked run of references (reference_leaf.h) and not a counted one, so that a cell is one word.
//
// Invariants. Plane i of an axis lies at lo + i * cell_size, in this order of operations and rounded twice: everybody computes
// it by plane(), so that there is one number for it. These numbers are monotone in i. Where cells are not much larger than the
// distance of neighbouring floats, planes may coincide: cells may be flat, but the grid never is. A cell is closed: it contains
// its faces. Cells are numbered with x fastest; the runs of references follow each other in the order of their cells, each
// belongs to one cell, and its slots ascend.
//
// Triangles are padded when they are sorted into cells, and the grid's box is padded likewise: padding.h says by how much, and
// why traversers need no epsilon. So a hit with t no larger than that of the ray's exit from a cell is the nearest.
#pragma once

#include <cstdint>
#include <type_traits>

#include "libaccel/core/aabb.h"
#include "libaccel/core/result.h"
#include "libaccel/structure/arrays.h"
#include "libaccel/structure/reference_leaf.h"

namespace accel {

// The most cells along an axis, whose numbers are exact in floats, and in all.
inline constexpr int kMaxGridResolution = 1 << 16;
inline constexpr std::uint64_t kMaxGridCells = 1u << 28;

// Cells along each axis.
struct GridResolution {
  std::int32_t x = 0, y = 0, z = 0;

  ACCEL_HD std::int32_t operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  ACCEL_HD std::uint64_t cells() const {
    return static_cast<std::uint64_t>(x) * static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(z);
  }
  bool operator==(const GridResolution&) const = default;
};

// Where the planes of a grid lie.
struct GridFrame {
  Vec3 lo{0.0f, 0.0f, 0.0f};
  Vec3 cell_size{0.0f, 0.0f, 0.0f};
  GridResolution resolution;

  // `index` is a whole number in [0, resolution[axis]].
  ACCEL_HD float plane(int axis, float index) const { return lo[axis] + index * cell_size[axis]; }
  ACCEL_HD float last_plane(int axis) const { return plane(axis, static_cast<float>(resolution[axis])); }
  ACCEL_HD Aabb bounds() const { return {lo, {last_plane(0), last_plane(1), last_plane(2)}}; }
};

// What a traverser needs, passed to kernels by value.
struct GridView {
  const std::uint32_t* cells = nullptr;  // names of leaves; null: an empty scene
  ReferenceLeavesView leaves;
  GridFrame frame;
};

// What of a Grid is no array.
struct GridWords {
  GridFrame frame;
};
static_assert(sizeof(GridWords) == 36 && std::is_trivially_copyable_v<GridWords>);

// The owning structure. An empty scene has no cells and no resolution.
struct Grid : GridWords {
  static constexpr const char* kName = "grid";
  using View = GridView;
  using Words = GridWords;

  Buffer<std::uint32_t> cells;
  ReferenceLeaves leaves;

  template <class Self, class Visit>
  static void for_each_array(Self& self, Visit&& visit) {
    visit("cells", self.cells);
    ReferenceLeaves::for_each_array(self.leaves, visit);
  }
  std::size_t size_bytes() const { return bytes_of_arrays(*this); }
  GridView view() const { return {cells.data(), leaves.view(), frame}; }
};

// Proves every invariant that traversal relies on, whatever the bytes are: resolution and number of cells, finite planes that
// ascend, cells that name the runs of references in order, slots and prim_ids in range.
Status validate(const Grid& grid, std::uint64_t triangle_count);

}  // namespace accel
