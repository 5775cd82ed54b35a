// Puts references into the order of a Z-curve through the centres of their boxes.
//
// Morton 1966; Lauterbach et al. 2009, "Fast BVH Construction on GPUs". Codes have 63 bits, 21 an axis, so that a teapot in a
// stadium still has an order of its own. The scale is the same along all axes, that of the widest: cells of the curve are
// cubes, and flat scenes waste no quality on an axis that they do not have.
//
// Few scenes need all the bits: the upper half is sorted first, and then, by itself, each run in which it does not differ.
// References with the same code keep their order. O(n); the pairs of codes and numbers twice, and the references twice, while
// it runs. The same for any number of threads.
#pragma once

#include "libaccel/build/references.h"

namespace accel {

// The references that there are, sorted; the storage of `references` is released.
Buffer<Reference> in_curve_order(BuildContext& context, References& references);

}  // namespace accel
