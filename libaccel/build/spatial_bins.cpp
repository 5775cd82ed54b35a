#include "libaccel/build/spatial_bins.h"

#include <algorithm>
#include <limits>

#include "libaccel/build/parallel.h"
#include "libaccel/build/sah_bins.h"
#include "libaccel/geometry/clip_triangle.h"

namespace accel {
namespace {

// The slabs that a box enters and leaves, by axis.
struct SlabRange {
  std::int32_t first[4], last[4];

  SlabRange(const Box4& box, const SlabMapping& mapping) {
    mapping.position(box.lo).truncate_to(first);
    mapping.position(box.hi).truncate_to(last);
  }
};

}  // namespace

SlabMapping::SlabMapping(const Box4& node, int bins) : lo_(node.lo.xyz()), bins_(bins) {
  const Vec3 extent = (node.hi - node.lo).xyz();
  Vec3 scale;
  for (int a = 0; a < 3; ++a) {
    width_[a] = extent[a] / static_cast<float>(bins);
    if (extent[a] > 0) scale[a] = std::min(static_cast<float>(bins) / extent[a], std::numeric_limits<float>::max());
  }
  base_ = node.lo;
  scale_ = Float4::of(scale);
  last_ = Float4::splat(static_cast<float>(bins - 1));
}

SlabCounts SlabCounts::of(const Reference* references, std::size_t begin, std::size_t end, const SlabMapping& mapping) {
  return reduce_chunks<SlabCounts>(begin, end, [&](std::size_t first, std::size_t last) {
    SlabCounts counts;
    counts.bins_ = mapping.bins();
    std::fill_n(&counts.entries_[0][0], 3 * mapping.bins(), 0u), std::fill_n(&counts.exits_[0][0], 3 * mapping.bins(), 0u);
    for (std::size_t i = first; i < last; ++i) {
      const SlabRange range(references[i].box(), mapping);
      for (int a = 0; a < 3; ++a) ++counts.entries_[range.first[a]][a], ++counts.exits_[range.last[a]][a];
    }
    return counts;
  });
}

SlabCounts& SlabCounts::operator+=(const SlabCounts& other) {
  for (int b = 0; b < bins_; ++b)
    for (int a = 0; a < 3; ++a) entries_[b][a] += other.entries_[b][a], exits_[b][a] += other.exits_[b][a];
  return *this;
}

bool SlabCounts::can_split(int axis, std::size_t n, std::size_t spare) const {
  std::uint32_t left = 0, gone = 0;  // entered and left before the plane
  for (int b = 1; b < bins_; ++b) {
    left += entries(axis, b - 1), gone += exits(axis, b - 1);
    if (can_split_at(left, static_cast<std::uint32_t>(n) - gone, n, spare)) return true;
  }
  return false;
}

void SpatialBins::clear(int bins) {
  bins_ = bins;
  for (int b = 0; b < bins; ++b)
    for (int a = 0; a < 3; ++a) boxes_[b][a] = Box4();
}

// Cuts the part of the triangle in `box` into the slabs first to last.
void SpatialBins::chop(const Triangle& triangle, const Box4& box, const SlabMapping& mapping, int axis, int first, int last) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const TriangleSlicer slicer(triangle, axis);
  Box4 below;  // the section at the slab's lower plane
  float lower = -kInfinity;
  for (int b = first; b <= last; ++b) {
    const float upper = b < last ? mapping.plane(axis, b + 1) : kInfinity;
    Box4 part = below;
    if (b < last) part.extend(below = slicer.section(upper));
    slicer.extend_by_vertices(lower, upper, part);
    const Box4 slab{max_of(box.lo, box.lo.with_lane(axis, lower)), min_of(box.hi, box.hi.with_lane(axis, upper))};
    part = intersection(part, slab);
    if (!part.empty()) boxes_[b][axis].extend(part);
    lower = upper;
  }
}

void SpatialBins::add(const TriangleMesh& mesh, const Reference* references, std::size_t begin, std::size_t end,
                      const SlabMapping& mapping, const Axes& axes) {
  for (std::size_t i = begin; i < end; ++i) {
    const Box4 box = references[i].box();
    const SlabRange range(box, mapping);
    for (int k = 0; k < axes.count; ++k) {
      const int a = axes.axis[k];
      if (range.first[a] == range.last[a])
        boxes_[range.first[a]][a].extend(box);
      else
        chop(mesh.triangle(references[i].prim_id), box, mapping, a, range.first[a], range.last[a]);
    }
  }
}

SpatialBins& SpatialBins::operator+=(const SpatialBins& other) {
  for (int b = 0; b < bins_; ++b)
    for (int a = 0; a < 3; ++a) boxes_[b][a].extend(other.boxes_[b][a]);
  return *this;
}

void SpatialBins::fill(const TriangleMesh& mesh, const Reference* references, std::size_t begin, std::size_t end,
                       const SlabMapping& mapping, const Axes& axes) {
  if (end - begin < kParallelSize) {
    clear(mapping.bins());
    add(mesh, references, begin, end, mapping, axes);
    return;
  }
  *this = reduce_chunks<SpatialBins>(begin, end, [&](std::size_t b, std::size_t e) {
    SpatialBins part;
    part.clear(mapping.bins());
    part.add(mesh, references, b, e, mapping, axes);
    return part;
  });
}

SpatialSplit SpatialBins::best_split(const TriangleMesh& mesh, const Reference* references, std::size_t begin, std::size_t end,
                                     const Box4& node, const SlabMapping& mapping, std::size_t spare, float traversal_cost,
                                     float intersection_cost) {
  const std::size_t n = end - begin;
  const SlabCounts counts = SlabCounts::of(references, begin, end, mapping);
  Axes axes;
  for (int a = 0; a < 3; ++a)
    if (counts.can_split(a, n, spare)) axes.axis[axes.count++] = a;
  if (axes.count == 0) return SpatialSplit();
  SpatialBins bins;
  bins.fill(mesh, references, begin, end, mapping, axes);
  return bins.choose(counts, axes, node, mapping, n, spare, traversal_cost, intersection_cost);
}

SpatialSplit SpatialBins::choose(const SlabCounts& counts, const Axes& axes, const Box4& node, const SlabMapping& mapping,
                                 std::size_t n, std::size_t spare, float traversal_cost, float intersection_cost) const {
  const Float4 scale = unit_scale(node);
  const float area = node.half_area(scale);
  float best = std::numeric_limits<float>::infinity();
  int best_bin = 0;
  SpatialSplit split;
  for (int k = 0; k < axes.count; ++k) {
    const int axis = axes.axis[k];
    // From the right: area and count of all bins from b on.
    float right_area[kMaxSpatialBins];
    std::uint32_t right_count[kMaxSpatialBins];
    Box4 box;
    std::uint32_t count = 0;
    for (int b = bins_ - 1; b > 0; --b) {
      box.extend(boxes_[b][axis]), count += counts.exits(axis, b);
      right_area[b] = box.half_area(scale), right_count[b] = count;
    }
    // From the left, choosing.
    box = Box4(), count = 0;
    for (int b = 1; b < bins_; ++b) {
      box.extend(boxes_[b - 1][axis]), count += counts.entries(axis, b - 1);
      const float cost = box.half_area(scale) * static_cast<float>(count) + right_area[b] * static_cast<float>(right_count[b]);
      if (!can_split_at(count, right_count[b], n, spare) || !(cost < best)) continue;
      best = cost, best_bin = b;
      split.axis = axis, split.count[0] = count, split.count[1] = right_count[b];
    }
  }
  if (!(best < std::numeric_limits<float>::infinity()) || !(area > 0)) return SpatialSplit();

  split.cost = traversal_cost + intersection_cost * best / area;
  split.position = mapping.plane(split.axis, best_bin);
  for (int b = 0; b < bins_; ++b) split.box[b < best_bin ? 0 : 1].extend(boxes_[b][split.axis]);
  return split;
}

}  // namespace accel
