// Triangle references: what builders sort into trees in place of the triangles.
//
// A reference is a box and a prim_id. After spatial splits several references name one triangle; each box then contains the
// part of the triangle that its reference stands for.
#pragma once

#include <cstdint>

#include "libaccel/build/build_context.h"
#include "libaccel/core/buffer.h"
#include "libaccel/core/float4_memory_simd.h"

namespace accel {

// Zeros are positive in both corners, so that minima and maxima do not depend on the order in which they are taken.
struct alignas(32) Reference {
  Vec3 lo;
  std::uint32_t prim_id;
  Vec3 hi;
  std::uint32_t side;  // scratch of the splitter that partitions the reference

  void set(const Box4& box, std::uint32_t id) { store_with_word(&lo, box.lo, id), store_with_word(&hi, box.hi, 0); }
  Box4 box() const { return {Float4::load_xyz(lo), Float4::load_xyz(hi)}; }
  Aabb bounds() const { return {lo, hi}; }
  void set_bounds(const Aabb& b) { lo = b.lo, hi = b.hi; }
};
static_assert(sizeof(Reference) == 32);

// Twice the box's centre: builders compare centres with each other only, and the half would cost a rounding in denormals.
inline Float4 doubled_center(const Box4& box) { return box.lo + box.hi; }

// The bounds of a set of references: of their boxes, and of their doubled centres.
struct SetBounds {
  Box4 boxes, centers;

  void extend(const Box4& box) {
    boxes.extend(box);
    centers.extend(doubled_center(box));
  }
  SetBounds& operator+=(const SetBounds& other) {
    boxes.extend(other.boxes), centers.extend(other.centers);
    return *this;
  }
};
SetBounds bounds_of(const Reference* references, std::size_t begin, std::size_t end);

struct References {
  Buffer<Reference> storage;  // `count` references and room for more
  std::size_t count = 0;
  SetBounds bounds;
};

// One reference for each triangle that a ray can hit, in mesh order, with room for `spare` more; counts the others in the
// report.
References make_references(BuildContext& context, std::size_t spare);

// The same with the reference of triangle i at storage[i], where those that no ray can hit have an empty box.
References make_sparse_references(BuildContext& context);

}  // namespace accel
