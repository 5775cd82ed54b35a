// Groups of rays, one in each SIMD lane, through a binary tree with one stack: Wald et al. 2001, "Interactive Rendering with
// Coherent Ray Tracing". What serves rays that are near each other but whose frustums (packet/frustum.h) meet too much, as
// those to a large light.
//
// A lane takes part in the steps of its own ray alone: the box test is that of trace/box_pair.h, and a child that is postponed
// keeps the distance at which each ray enters it. So a ray meets the triangles that it meets by itself, in another order, and
// has the same hit bit for bit. Memory: a distance for each ray on each level.
#pragma once

#include <cstdint>

#include "libaccel/packet/localized.h"

namespace accel {

// How well rays fill the lanes.
struct GroupWork {
  std::uint64_t nodes = 0;  // that groups have visited
  std::uint64_t rays = 0;   // in them, over all these visits
};

// hits[i] answers rays[i] for all rays of active packets; nothing else is written. faces[k] is the face of ray ids[k]. The tree
// is not empty and no deeper than kBvh2StackSize. Of the batch, only rays and packets are read.
GroupWork intersect_groups_simd(const Bvh2View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits);
GroupWork occlude_groups_simd(const Bvh2View& view, const LocalizedBatch& batch, const std::uint8_t* faces,
                              std::uint8_t* occluded);

// Rays in a vector of the target that runs.
std::uint32_t rays_per_group();

}  // namespace accel
