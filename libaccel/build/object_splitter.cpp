#include "libaccel/build/object_splitter.h"

#include <algorithm>

namespace accel {
namespace {

// How many bins a set of n references deserves: as many as can tell its references apart.
int bins_for(std::size_t n, const BuildOptions& options) {
  return static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(options.bins), 8 + n / 8));
}

// Makes children of the two sides of a partition. Room behind the set stays behind the second.
void assign_sides(const ReferenceSet& set, const Partition& sides, ReferenceSet (&children)[2]) {
  children[0] = {set.begin, sides.middle, sides.middle, sides.side[0]};
  children[1] = {sides.middle, set.end, set.limit, sides.side[1]};
}

}  // namespace

ObjectCandidate find_object_split(const Reference* references, const ReferenceSet& set, const BuildOptions& options) {
  ObjectCandidate candidate{BinMapping(set.bounds.centers, bins_for(set.size(), options)), {}};
  if (must_balance(set.size(), set.levels, options.max_leaf_size)) return candidate;
  ObjectBins bins;
  bins.fill(references, set.begin, set.end, candidate.mapping);
  candidate.split = bins.best_split(set.bounds.boxes, options.traversal_cost, options.intersection_cost);
  return candidate;
}

void apply_object_split(Reference* references, const ReferenceSet& set, const ObjectCandidate& candidate,
                        ReferenceSet (&children)[2]) {
  if (!candidate.split.found()) {
    assign_sides(set, partition_at_median(references, set.begin, set.end, set.bounds), children);
    return;
  }
  const auto is_right = [&mapping = candidate.mapping, axis = candidate.split.axis,
                         first_right = static_cast<float>(candidate.split.bin)](const Reference&, const Box4& box) {
    return mapping.position(box).xyz()[axis] >= first_right;
  };
  assign_sides(set, partition(references, set.begin, set.end, is_right), children);
}

}  // namespace accel
