#include "libaccel/build/spatial_bins.h"

#include <algorithm>
#include <limits>

#include "libaccel/build/parallel.h"
#include "libaccel/build/sah_bins.h"
#include "libaccel/geometry/clip_triangle.h"

namespace accel {

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

void SpatialBins::clear(int bins) {
  bins_ = bins;
  for (int b = 0; b < bins; ++b)
    for (int a = 0; a < 3; ++a) boxes_[b][a] = Box4(), entries_[b][a] = exits_[b][a] = 0;
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
                      const SlabMapping& mapping) {
  for (std::size_t i = begin; i < end; ++i) {
    const Box4 box = references[i].box();
    std::int32_t first[4], last[4];
    mapping.position(box.lo).truncate_to(first);
    mapping.position(box.hi).truncate_to(last);
    for (int a = 0; a < 3; ++a) {
      ++entries_[first[a]][a], ++exits_[last[a]][a];
      if (first[a] == last[a]) {
        boxes_[first[a]][a].extend(box);
      } else {
        chop(mesh.triangle(references[i].prim_id), box, mapping, a, first[a], last[a]);
      }
    }
  }
}

SpatialBins& SpatialBins::operator+=(const SpatialBins& other) {
  for (int b = 0; b < bins_; ++b)
    for (int a = 0; a < 3; ++a) {
      boxes_[b][a].extend(other.boxes_[b][a]);
      entries_[b][a] += other.entries_[b][a], exits_[b][a] += other.exits_[b][a];
    }
  return *this;
}

void SpatialBins::fill(const TriangleMesh& mesh, const Reference* references, std::size_t begin, std::size_t end,
                       const SlabMapping& mapping) {
  if (end - begin < kParallelSize) {
    clear(mapping.bins());
    add(mesh, references, begin, end, mapping);
    return;
  }
  *this = reduce_chunks<SpatialBins>(begin, end, [&](std::size_t b, std::size_t e) {
    SpatialBins part;
    part.clear(mapping.bins());
    part.add(mesh, references, b, e, mapping);
    return part;
  });
}

SpatialSplit SpatialBins::best_split(const Box4& node, const SlabMapping& mapping, std::size_t n, std::size_t spare,
                                     float traversal_cost, float intersection_cost) const {
  const Float4 scale = unit_scale(node);
  const float area = node.half_area(scale);
  float best = std::numeric_limits<float>::infinity();
  int best_bin = 0;
  SpatialSplit split;
  for (int axis = 0; axis < 3; ++axis) {
    // From the right: area and count of all bins from b on.
    float right_area[kMaxSpatialBins];
    std::uint32_t right_count[kMaxSpatialBins];
    Box4 box;
    std::uint32_t count = 0;
    for (int b = bins_ - 1; b > 0; --b) {
      box.extend(boxes_[b][axis]), count += exits_[b][axis];
      right_area[b] = box.half_area(scale), right_count[b] = count;
    }
    // From the left, choosing.
    box = Box4(), count = 0;
    for (int b = 1; b < bins_; ++b) {
      box.extend(boxes_[b - 1][axis]), count += entries_[b - 1][axis];
      const float cost = box.half_area(scale) * static_cast<float>(count) + right_area[b] * static_cast<float>(right_count[b]);
      const bool affordable = std::size_t{count} + right_count[b] - n <= spare;
      if (count == 0 || right_count[b] == 0 || !affordable || !(cost < best)) continue;
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
