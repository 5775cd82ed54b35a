// Splits reference sets by the better of an object split and a spatial split: Stich et al. 2009, section 4.
#pragma once

#include "libaccel/build/object_splitter.h"
#include "libaccel/build/spatial_bins.h"

namespace accel {

// A Splitter of TopDownBuilder. The room behind each set is its share of the reference budget: a spatial split is considered
// only where its duplicates fit, and what is left is shared out between the children, so that the budget holds and nothing
// depends on the order in which tasks run.
class SpatialSplitter {
 public:
  SpatialSplitter(const TriangleMesh& mesh, Reference* references, const Box4& root, const BuildOptions& options);

  bool split(const ReferenceSet& set, ReferenceSet (&children)[2]) const;

 private:
  // Whether the children of an object split overlap by enough for a spatial split to be worth a try.
  bool overlaps(const ObjectSplit& split) const;
  SpatialSplit find_spatial_split(const ReferenceSet& set) const;
  bool apply_spatial_split(const ReferenceSet& set, const SpatialSplit& split, ReferenceSet (&children)[2]) const;

  const TriangleMesh& mesh_;
  Reference* references_;
  const BuildOptions& options_;
  float min_overlap_;  // area
};

}  // namespace accel
