// What the surface-area heuristic of kd-trees counts with: MacDonald and Booth 1990; Wald and Havran 2006, section 3.
//
// Deviation: the cost of a leaf. A visit of a leaf that has triangles costs beside their tests the fetch of its references and
// the end of a loop that no branch predictor foresees.
//
// kKdStepCost and kKdLeafCost say what kdtree/stack spends. They are not tuned to a scene: leaf costs from 1 to 2 tests and
// steps from 1.25 to 1.75 are as good. Against a model without them (no leaf costs, a step for a test), rays take 3 % less time
// in the median of six scenes, primary and diffuse, and trees 15 to 20 % less memory; only in BART Kitchen, whose few large
// walls are no longer cut out of the empty room, primary rays take 5 % more. A bonus for empty space from 0 to 0.2, the
// paper's, makes no difference.
//
// Where a leaf would be dear, no single plane may pay, but some together do, as those that cut the corner with the furniture
// out of a room. There the builder goes on for some planes, and takes back what has not paid in the end. In BART Kitchen that
// saves a fifth of the time of primary rays; elsewhere expected costs are 0 to 2 % less, and times the same. A threshold from
// 0.001 to 0.03 is as good; without one, trees take 40 % longer to build and are 15 % larger for the same speed.
#pragma once

#include <limits>

#include "libaccel/build/builder.h"

namespace accel {

// What a step past a plane costs, in steps through a node as BuildOptions::traversal_cost has them; and what visiting a leaf
// that has triangles costs beside their tests, in tests.
inline constexpr double kKdStepCost = 1.5;
inline constexpr double kKdLeafCost = 2.0;

// The expected cost of a leaf, for a ray that meets the scene's box, from which on it is dear; in tests.
inline constexpr double kKdDearLeaf = 0.003;

// In any unit: a step, a test, a leaf; the share by which planes that cut off empty space are cheaper; and a dear leaf, which
// no leaf is by default.
struct KdCosts {
  double traversal, intersection, leaf, empty_bonus;
  double dear_leaf = std::numeric_limits<double>::infinity();

  // The default model, in the unit of the options' costs.
  static KdCosts of(const BuildOptions& options) {
    const double step = options.traversal_cost, test = options.intersection_cost;
    return {kKdStepCost * step, test, kKdLeafCost * test, options.empty_bonus, kKdDearLeaf * test};
  }

  // Of a leaf that is met.
  double of_leaf(double triangles) const { return triangles > 0 ? leaf + intersection * triangles : 0.0; }
};

}  // namespace accel
