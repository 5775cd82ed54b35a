#include "libaccel/build/object_splitter.h"

#include <algorithm>

namespace accel {

int bins_for(std::size_t n, const BuildOptions& options) {
  return static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(options.bins), 8 + n / 8));
}

void assign_sides(const ReferenceSet& set, const Partition& partition, ReferenceSet (&children)[2]) {
  children[0] = {set.begin, partition.middle, partition.middle, partition.side[0]};
  children[1] = {partition.middle, set.end, set.limit, partition.side[1]};
}

bool ObjectSplitter::split(const ReferenceSet& set, ReferenceSet (&children)[2]) const {
  const std::size_t n = set.size();
  ObjectSplit best;
  const BinMapping mapping(set.bounds.centers, bins_for(n, options_));
  if (!must_balance(n, set.levels, options_.max_leaf_size)) {
    ObjectBins bins;
    bins.fill(references_, set.begin, set.end, mapping);
    best = bins.best_split(set.bounds.boxes, options_.traversal_cost, options_.intersection_cost);
    const float leaf_cost = options_.intersection_cost * static_cast<float>(n);
    if (n <= static_cast<std::size_t>(options_.max_leaf_size) && !(best.cost < leaf_cost)) return false;
  }
  if (!best.found()) {
    assign_sides(set, partition_at_median(references_, set.begin, set.end, set.bounds), children);
    return true;
  }
  const auto first_right = static_cast<float>(best.bin);
  const int axis = best.axis;
  assign_sides(set,
               partition(references_, set.begin, set.end,
                         [&](const Reference&, const Box4& box) { return mapping.position(box).xyz()[axis] >= first_right; }),
               children);
  return true;
}

}  // namespace accel
