// The surface-area heuristic for spatial splits: Stich, Friedrich and Dietrich 2009, "Spatial Splits in Bounding Volume
// Hierarchies", section 4.1, "chopped binning".
//
// Bins are slabs of the node's box of equal width. A reference counts in the bin it enters and in the bin it leaves, and
// extends the boxes of all bins between by its triangle's part there.
#pragma once

#include <cstddef>
#include <cstdint>

#include "libaccel/build/references.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel {

inline constexpr int kMaxSpatialBins = 16;

// Slabs along each axis.
class SlabMapping {
 public:
  SlabMapping(const Box4& node, int bins);

  int bins() const { return bins_; }
  // The slabs of a point, in units of slabs; monotonous in every coordinate. NaN counts as 0.
  Float4 position(Float4 point) const { return min_of(max_of((point - base_) * scale_, Float4::splat(0.0f)), last_); }
  // The plane below a slab.
  float plane(int axis, int bin) const { return lo_[axis] + width_[axis] * static_cast<float>(bin); }

 private:
  Float4 base_, scale_, last_;
  Vec3 lo_, width_;
  int bins_;
};

// A plane, and the parts of the node's triangles on its sides.
struct SpatialSplit {
  float cost = std::numeric_limits<float>::infinity();  // as ObjectSplit::cost
  int axis = 0;
  float position = 0;
  Box4 box[2];
  std::uint32_t count[2] = {0, 0};

  bool found() const { return cost < std::numeric_limits<float>::infinity(); }
  // References that the split adds.
  std::size_t duplicates(std::size_t n) const { return std::size_t{count[0]} + count[1] - n; }
};

class SpatialBins {
 public:
  // Bins references[begin, end), in parallel where they are many.
  void fill(const TriangleMesh& mesh, const Reference* references, std::size_t begin, std::size_t end,
            const SlabMapping& mapping);
  // The best split that adds at most `spare` references to the n that are there.
  SpatialSplit best_split(const Box4& node, const SlabMapping& mapping, std::size_t n, std::size_t spare, float traversal_cost,
                          float intersection_cost) const;

  SpatialBins& operator+=(const SpatialBins& other);

 private:
  void clear(int bins);
  void add(const TriangleMesh& mesh, const Reference* references, std::size_t begin, std::size_t end,
           const SlabMapping& mapping);
  void chop(const Triangle& triangle, const Box4& box, const SlabMapping& mapping, int axis, int first, int last);

  int bins_ = 0;
  Box4 boxes_[kMaxSpatialBins][3];
  std::uint32_t entries_[kMaxSpatialBins][3], exits_[kMaxSpatialBins][3];
};

}  // namespace accel
