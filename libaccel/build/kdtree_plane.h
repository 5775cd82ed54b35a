// Where to split a node of a kd-tree: the sweep of the surface-area heuristic over the sorted events of a set.
//
// Wald and Havran 2006, section 3 (cost model, termination) and 4.2 (sweep). The expected cost of a ray in a node that is split
// at a plane is
//
//     traversal_cost + (area(lower) * cost(below) + area(upper) * cost(above)) / area(node)
//
// times (1 - empty_bonus) where one side is empty, with cost(n) = leaf_cost + intersection_cost * n, and nothing for no
// triangles (kdtree_costs.h). The counts are those of the padded boxes; every event's position is tried.
#pragma once

#include <limits>

#include "libaccel/build/kdtree_costs.h"
#include "libaccel/build/kdtree_events.h"

namespace accel {

struct KdPlane {
  int axis = 0;
  float position = 0;
  double cost = std::numeric_limits<double>::infinity();  // as above, times the node's half area
  bool is_limited = false;                                // a cheaper plane was refused for set.limit's sake

  bool found() const { return cost < std::numeric_limits<double>::infinity(); }
};

// The cheapest plane strictly within the set's cell that costs less than `most` and makes at most set.limit references of the
// set. Of equals, the first axis and the lowest plane. O(n), on several threads where the set is large.
KdPlane cheapest_plane(const KdSet& set, const KdCosts& costs, double most = std::numeric_limits<double>::infinity());

}  // namespace accel
