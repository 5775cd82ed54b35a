// The box that random and edge rays start in and around.
#pragma once

#include "libaccel/core/aabb.h"
#include "libaccel/core/counter_rng.h"

namespace accel {

// The box, enlarged on every side by `share` of its largest extent (of its largest coordinate or 1, if it is one point), and
// cut to the range of the library. An empty box counts as the unit cube.
Aabb enlarged(const Aabb& bounds, float share);

// Uniform in the box.
Vec3 point_in_box(const Aabb& box, CounterRng& rng);

}  // namespace accel
