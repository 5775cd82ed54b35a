// Lowers the cost of a binary tree by taking subtrees out and putting them in where they cost least.
//
// Bittner, Hapala and Havran 2013, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies"; in the form of Meister
// and Bittner 2018, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization". A round has two steps:
//
//   search  The best place of each of some subtrees (build/reinsertion_search.h): in parallel, in a tree that does not change.
//   move    Those that have a better place go there, the ones that gain most first, ties by their numbers.
//
// Deviations. The paper moves subtrees in parallel, and locks nodes by atomic maxima of gains, so that no two moves meet; what
// gets no lock waits for the next round. Here moves follow each other, and each is made only if it lowers the cost of the tree
// as it is by then. So the cost never rises, there are no locks, and no move is lost that still gains; a tenth of a round is
// not parallel. The paper searches for every k-th subtree; here, for those that may gain most: by how much a subtree's parent
// is larger than itself. First for one in kFirstShare, then, whenever a round lowers the cost by less than kGainOfSameShare of
// it, for twice as many: few large subtrees make most of the gain, and small ones find their places when the large ones are in
// theirs.
//
// Of the SAH cost, what leaves contribute stays the same: leaves keep their triangles and boxes, after spatial splits too. The
// gain is all in the areas of inner nodes, so where to put what does not depend on the options' costs.
//
// Rounds end when the options say so, or when one lowers the SAH cost by less than kLeastRoundGain of it.
//
// O(n log n) on usual trees, and 16 bytes a node beside the structure; then for the new order of nodes and leaves, the
// structure once more. The same bytes for any number of threads, unless seconds are limited.
#pragma once

#include "libaccel/build/build_context.h"
#include "libaccel/structure/bvh2.h"

namespace accel {

inline constexpr std::size_t kFirstShare = 16;
inline constexpr double kGainOfSameShare = 1e-2, kLeastRoundGain = 1e-3;

// The rounds that the options ask for; nothing where that is none. The tree is valid, without annotations, and parents come
// before their children. No path gets longer than the options allow or than what traversers with a stack accept, or than the
// longest is already. Fails when progress says stop; the structure is then of no use. May throw std::bad_alloc.
Status reinsert(BuildContext& context, Bvh2& bvh);

}  // namespace accel
