// From a binary tree to one with eight children a node, at the least cost that any collapse has.
//
// Wald, Benthin and Boulos 2008, "Getting Rid of Packets", section 3.1; in the form of Ylitie, Karras and Laine 2017,
// "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.1. For every binary node n and every i
// up to seven, cost(n, i) is the least SAH cost of a forest of at most i wide subtrees over n, found from the leaves up; a wide
// node is a forest of eight. A subtree may become one leaf of up to max_leaf_size triangles. Whatever the choices are, each is
// a choice among the binary tree's own boxes.
//
// Deviations. A leaf costs by the block of four triangles that are tested at once, not by the triangle. Triangles that spatial
// splits gave to several leaves that become one are in it once.
//
// Where nodes and blocks go, build/wide_layout.h says.
//
// Nothing here recurses by the depth of the tree. O(n), and 36 bytes a binary node beside the two trees and the layout.
// Parallel, and the same bytes for any number of threads.
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/structure/bvh2.h"
#include "libaccel/structure/bvh8.h"

namespace accel {

// Costs and leaf sizes are those of the options: a step through a wide node is one of traversal_cost, and a block's test one of
// intersection_cost. Fails when blocks or nodes outgrow the bits of a reference. May throw std::bad_alloc.
Result<Bvh8> collapse_wide(const Bvh2& bvh, const BuildOptions& options);

// The most memory that making one from the other took, both trees included.
std::uint64_t collapse_peak_bytes(const Bvh2& bvh, const Bvh8& wide);

}  // namespace accel
