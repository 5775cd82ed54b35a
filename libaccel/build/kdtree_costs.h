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
#pragma once

#include "libaccel/build/builder.h"

namespace accel {

// What a step past a plane costs, in steps through a node as BuildOptions::traversal_cost has them; and what visiting a leaf
// that has triangles costs beside their tests, in tests.
inline constexpr double kKdStepCost = 1.5;
inline constexpr double kKdLeafCost = 2.0;

// In any unit: a step, a test, a leaf; and the share by which planes that cut off empty space are cheaper.
struct KdCosts {
  double traversal, intersection, leaf, empty_bonus;

  // The default model, in the unit of the options' costs.
  static KdCosts of(const BuildOptions& options) {
    const double step = options.traversal_cost, test = options.intersection_cost;
    return {kKdStepCost * step, test, kKdLeafCost * test, options.empty_bonus};
  }

  // Of a leaf that is met.
  double of_leaf(double triangles) const { return triangles > 0 ? leaf + intersection * triangles : 0.0; }
};

}  // namespace accel
