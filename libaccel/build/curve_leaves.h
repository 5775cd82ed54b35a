// Cuts references that are in the order of a Z-curve into leaves of few.
//
// Of all ways to cut a piece of the curve into runs of at most `most` references, the cheapest: a run costs the area of its box
// by one block's test, and one child's part of its parent (kChildCost). It is found from right to left, O(n * most). Curves
// jump; the cheapest cuts are where they do.
//
// The curve is cut into windows of a fixed size first, so that leaves do not depend on the number of threads.
#pragma once

#include "libaccel/build/cluster_tree.h"
#include "libaccel/build/curve_order.h"

namespace accel {

// One cluster for each leaf, in the order of the curve, with room for what merges them. At least one reference.
ClusterTree cut_into_leaves(BuildContext& context, const References& references, const CurveOrder& order, std::uint32_t most);

}  // namespace accel
