// Splits reference sets by the surface-area heuristic so that each reference goes to one side.
#pragma once

#include "libaccel/build/partition.h"
#include "libaccel/build/sah_bins.h"
#include "libaccel/build/top_down.h"

namespace accel {

// A Splitter of TopDownBuilder.
class ObjectSplitter {
 public:
  ObjectSplitter(Reference* references, const BuildOptions& options) : references_(references), options_(options) {}

  bool split(const ReferenceSet& set, ReferenceSet (&children)[2]) const;

 private:
  Reference* references_;
  const BuildOptions& options_;
};

// How many bins a set of n references deserves: as many as can tell its references apart.
int bins_for(std::size_t n, const BuildOptions& options);

// Makes children of the two sides of a partition. Room behind the set stays behind the second.
void assign_sides(const ReferenceSet& set, const Partition& partition, ReferenceSet (&children)[2]);

}  // namespace accel
