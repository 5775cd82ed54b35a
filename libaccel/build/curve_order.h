// The order of references along a Z-curve through the centres of their boxes.
//
// Morton 1966; Lauterbach et al. 2009, "Fast BVH Construction on GPUs". Codes have 63 bits, 21 an axis, so that a teapot in a
// stadium still has an order of its own. The scale is the same along all axes, that of the widest: cells of the curve are
// cubes, and flat scenes waste no quality on an axis that they do not have.
//
// What is sorted are words: a code's upper bits, as many as there is room for, and behind them the number of the reference.
// Four digits are sorted first, which is enough for most. Then each run in which they do not differ is sorted by itself, by the
// bits that words have, if it is longer than a leaf; and what then is still the same by whole codes, if it is long. References
// with the same code, and those of shorter runs, keep their order. O(n) but for such runs, which are sorted by comparisons; 16
// bytes a reference while it runs, of which 8 remain. The same for any number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "libaccel/build/references.h"

namespace accel {

class CurveOrder {
 public:
  CurveOrder() = default;
  // The least `id_bits` bits of a word are the number of a reference.
  CurveOrder(Buffer<std::uint64_t> words, std::size_t size, int id_bits)
      : words_(std::move(words)), size_(size), id_mask_((std::uint64_t{1} << id_bits) - 1) {}

  std::size_t size() const { return size_; }
  std::size_t size_bytes() const { return words_.size_bytes(); }
  // The prim_id of the reference that comes as number i.
  std::uint32_t operator[](std::size_t i) const { return static_cast<std::uint32_t>(words_[i] & id_mask_); }

 private:
  Buffer<std::uint64_t> words_;
  std::size_t size_ = 0;
  std::uint64_t id_mask_ = 0;
};

// Of sparse references: those that have a box.
CurveOrder curve_order(BuildContext& context, const References& references);

// The references in that order.
Buffer<Reference> in_order(const References& references, const CurveOrder& order);

}  // namespace accel
