#include "libaccel/build/sah_bins.h"

#include <algorithm>
#include <limits>

#include "libaccel/build/parallel.h"

namespace accel {
namespace {

// x as a divisor's reciprocal, or the largest float where that overflows.
float finite_reciprocal(float x) { return std::min(1.0f / x, std::numeric_limits<float>::max()); }

}  // namespace

Float4 unit_scale(const Box4& box) {
  const Vec3 e = (box.hi - box.lo).xyz();
  return Float4::splat(finite_reciprocal(std::max({e.x, e.y, e.z})));
}

BinMapping::BinMapping(const Box4& centers, int bins) : bins_(bins) {
  Vec3 scale;
  const Vec3 extent = (centers.hi - centers.lo).xyz();
  for (int a = 0; a < 3; ++a)
    if (extent[a] > 0) scale[a] = std::min(static_cast<float>(bins) / extent[a], std::numeric_limits<float>::max());
  base_ = centers.lo;
  scale_ = Float4::of(scale);
  last_ = Float4::splat(static_cast<float>(bins - 1));
}

void ObjectBins::clear(int bins) {
  bins_ = bins;
  for (int b = 0; b < bins; ++b)
    for (int a = 0; a < 3; ++a) boxes_[b][a] = Box4(), counts_[b][a] = 0;
}

void ObjectBins::add(const Reference* references, std::size_t begin, std::size_t end, const BinMapping& mapping) {
  for (std::size_t i = begin; i < end; ++i) {
    const Box4 box = references[i].box();
    std::int32_t bin[4];
    mapping.position(box).truncate_to(bin);
    boxes_[bin[0]][0].extend(box), ++counts_[bin[0]][0];
    boxes_[bin[1]][1].extend(box), ++counts_[bin[1]][1];
    boxes_[bin[2]][2].extend(box), ++counts_[bin[2]][2];
  }
}

ObjectBins& ObjectBins::operator+=(const ObjectBins& other) {
  for (int b = 0; b < bins_; ++b)
    for (int a = 0; a < 3; ++a) boxes_[b][a].extend(other.boxes_[b][a]), counts_[b][a] += other.counts_[b][a];
  return *this;
}

void ObjectBins::fill(const Reference* references, std::size_t begin, std::size_t end, const BinMapping& mapping) {
  if (end - begin < kParallelSize) {
    clear(mapping.bins());
    add(references, begin, end, mapping);
    return;
  }
  *this = reduce_chunks<ObjectBins>(begin, end, [&](std::size_t b, std::size_t e) {
    ObjectBins part;
    part.clear(mapping.bins());
    part.add(references, b, e, mapping);
    return part;
  });
}

ObjectSplit ObjectBins::best_split(const Box4& node, float traversal_cost, float intersection_cost) const {
  const Float4 scale = unit_scale(node);
  float best = std::numeric_limits<float>::infinity();
  ObjectSplit split;
  for (int axis = 0; axis < 3; ++axis) {
    // From the right: area times count of all bins from b on.
    float right_cost[kMaxBins];
    std::uint32_t right_count[kMaxBins];
    Box4 box;
    std::uint32_t count = 0;
    for (int b = bins_ - 1; b > 0; --b) {
      box.extend(boxes_[b][axis]), count += counts_[b][axis];
      right_cost[b] = box.half_area(scale) * static_cast<float>(count), right_count[b] = count;
    }
    // From the left, choosing.
    box = Box4(), count = 0;
    for (int b = 1; b < bins_; ++b) {
      box.extend(boxes_[b - 1][axis]), count += counts_[b - 1][axis];
      const float cost = box.half_area(scale) * static_cast<float>(count) + right_cost[b];
      if (count == 0 || right_count[b] == 0 || !(cost < best)) continue;
      best = cost, split.axis = axis, split.bin = b;
    }
  }
  const float area = node.half_area(scale);
  if (!(best < std::numeric_limits<float>::infinity()) || !(area > 0)) return ObjectSplit();

  split.cost = traversal_cost + intersection_cost * best / area;
  for (int b = 0; b < bins_; ++b) (b < split.bin ? split.left : split.right).extend(boxes_[b][split.axis]);
  return split;
}

}  // namespace accel
