// Splits reference sets by the surface-area heuristic so that each reference goes to one side.
#pragma once

#include "libaccel/build/partition.h"
#include "libaccel/build/sah_bins.h"
#include "libaccel/build/top_down.h"

namespace accel {

// The best object split of a set, with the bins it is expressed in.
struct ObjectCandidate {
  BinMapping mapping;
  ObjectSplit split;  // not found() where no plane between bins separates anything, or where the set must be halved
};
ObjectCandidate find_object_split(const Reference* references, const ReferenceSet& set, const BuildOptions& options);

// Carries the candidate out, or halves the set at the median where there is none. Room behind the set stays behind the second
// child.
void apply_object_split(Reference* references, const ReferenceSet& set, const ObjectCandidate& candidate,
                        ReferenceSet (&children)[2]);

// Whether a set should be a leaf: it is small enough, and `split_cost` is not below the cost of testing all its triangles.
inline bool is_best_as_leaf(std::size_t size, float split_cost, const BuildOptions& options) {
  return size <= static_cast<std::size_t>(options.max_leaf_size) &&
         !(split_cost < options.intersection_cost * static_cast<float>(size));
}

// A Splitter of TopDownBuilder.
class ObjectSplitter {
 public:
  ObjectSplitter(Reference* references, const BuildOptions& options) : references_(references), options_(options) {}

  bool split(const ReferenceSet& set, ReferenceSet (&children)[2]) const {
    const ObjectCandidate candidate = find_object_split(references_, set, options_);
    if (is_best_as_leaf(set.size(), candidate.split.cost, options_)) return false;
    apply_object_split(references_, set, candidate, children);
    return true;
  }

 private:
  Reference* references_;
  const BuildOptions& options_;
};

}  // namespace accel
