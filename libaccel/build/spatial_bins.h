// The surface-area heuristic for spatial splits: Stich, Friedrich and Dietrich 2009, "Spatial Splits in Bounding Volume
// Hierarchies", section 4.1, "chopped binning".
//
// Bins are slabs of the node's box of equal width. A reference counts in the bin it enters and in the bin it leaves, and
// extends the boxes of all bins between by its triangle's part there. Deviation: references are counted before they are
// chopped, and only along axes that have a plane which the budget of references allows; most of the time goes into chopping.
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

// How many references enter and leave each slab.
class SlabCounts {
 public:
  // Counts references[begin, end), in parallel where they are many.
  static SlabCounts of(const Reference* references, std::size_t begin, std::size_t end, const SlabMapping& mapping);

  std::uint32_t entries(int axis, int bin) const { return entries_[bin][axis]; }
  std::uint32_t exits(int axis, int bin) const { return exits_[bin][axis]; }
  // Whether a plane of this axis has references on both sides and adds at most `spare` to the n that there are.
  bool can_split(int axis, std::size_t n, std::size_t spare) const;

  SlabCounts& operator+=(const SlabCounts& other);

 private:
  int bins_ = 0;
  std::uint32_t entries_[kMaxSpatialBins][3], exits_[kMaxSpatialBins][3];
};

// Whether a plane with so many references on its sides is one to choose.
inline bool can_split_at(std::uint32_t left, std::uint32_t right, std::size_t n, std::size_t spare) {
  return left > 0 && right > 0 && std::size_t{left} + right - n <= spare;
}

class SpatialBins {
 public:
  // The best split of references[begin, end) that adds at most `spare` to them. Works in parallel where they are many.
  static SpatialSplit best_split(const TriangleMesh& mesh, const Reference* references, std::size_t begin, std::size_t end,
                                 const Box4& node, const SlabMapping& mapping, std::size_t spare, float traversal_cost,
                                 float intersection_cost);

  SpatialBins& operator+=(const SpatialBins& other);

 private:
  // The axes of a node that have a plane to choose.
  struct Axes {
    int axis[3];
    int count = 0;
  };

  void clear(int bins);
  void fill(const TriangleMesh& mesh, const Reference* references, std::size_t begin, std::size_t end,
            const SlabMapping& mapping, const Axes& axes);
  void add(const TriangleMesh& mesh, const Reference* references, std::size_t begin, std::size_t end,
           const SlabMapping& mapping, const Axes& axes);
  void chop(const Triangle& triangle, const Box4& box, const SlabMapping& mapping, int axis, int first, int last);
  SpatialSplit choose(const SlabCounts& counts, const Axes& axes, const Box4& node, const SlabMapping& mapping, std::size_t n,
                      std::size_t spare, float traversal_cost, float intersection_cost) const;

  int bins_ = 0;
  Box4 boxes_[kMaxSpatialBins][3];
};

}  // namespace accel
