// The surface-area heuristic over bins: Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies".
//
// References fall into bins by the centres of their boxes, along all three axes at once; the candidates are the planes between
// bins.
//
// Areas are measured in units of the node's largest extent, so that scenes of any size neither overflow nor underflow, and
// costs in units of the node's area: cost = traversal + intersection * (area_left n_left + area_right n_right) / area_node.
#pragma once

#include <cstddef>
#include <cstdint>

#include "libaccel/build/references.h"

namespace accel {

// The scale that makes the largest extent of a box 1; finite.
Float4 unit_scale(const Box4& box);

// Which bin a reference falls into, along each axis. NaN, from a centre that no bin can resolve, counts as bin 0.
class BinMapping {
 public:
  BinMapping(const Box4& centers, int bins);

  int bins() const { return bins_; }
  // The position along each axis in units of bins; its floor is the bin.
  Float4 position(const Box4& box) const {
    const Float4 p = (doubled_center(box) - base_) * scale_;
    return min_of(max_of(p, Float4::splat(0.0f)), last_);
  }

 private:
  Float4 base_, scale_, last_;
  int bins_;
};

// A plane between bins, and what lies on its sides.
struct ObjectSplit {
  float cost = std::numeric_limits<float>::infinity();  // of a node split here, as above; infinite: no plane separates anything
  int axis = 0;
  int bin = 0;  // the first on the right side
  Box4 left, right;

  bool found() const { return cost < std::numeric_limits<float>::infinity(); }
};

// Boxes and counts of the bins. Default-constructed bins are not empty but undefined: clear() or fill() first.
class ObjectBins {
 public:
  // Bins references[begin, end), in parallel where they are many.
  void fill(const Reference* references, std::size_t begin, std::size_t end, const BinMapping& mapping);
  ObjectSplit best_split(const Box4& node, float traversal_cost, float intersection_cost) const;

  ObjectBins& operator+=(const ObjectBins& other);

 private:
  void clear(int bins);
  void add(const Reference* references, std::size_t begin, std::size_t end, const BinMapping& mapping);

  int bins_ = 0;
  Box4 boxes_[kMaxBins][3];
  std::uint32_t counts_[kMaxBins][3];
};

}  // namespace accel
