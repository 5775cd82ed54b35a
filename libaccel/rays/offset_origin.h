// Where a ray that leaves a surface starts, so that it does not meet the triangle that it leaves.
//
// After Pharr, Jakob and Humphreys, Physically Based Rendering (4th ed.), section 6.8.6, "Robust spawned ray origins": bound
// the error of the hit point, move along the normal by the bound, round outwards. Rays then start at t_min = 0; no epsilon is
// involved.
//
// Deviation: the book bounds the error of the point that its own test computes. Here the point is computed in double and the
// bound covers what the next ray's watertight test (geometry/watertight.h) will make of the triangle. With u = 2^-24, E the
// largest coordinate difference between the origin and the triangle's vertices, and n the unit normal:
//   - the interpolated point is within 2^-50 (E + |p|) of the plane on each axis (four roundings in double);
//   - the test sees a vertex displaced by at most gamma(7) E on each axis (differences, shear and their rounding);
//   - its t, times the length of the direction, is off by at most sqrt(3) gamma(5) E (three products, two sums, two quotients,
//     divided by the direction's largest component), which is less than gamma(9) E |n|_1, as the 1-norm |n|_1 is at least 1.
// Together: the origin lies |n|_1 (gamma(16) E + 2^-50 (E + |p|)) above the plane, and no rounding of those takes it below.
//
// Not covered: the rounding of the edge functions, which matters for triangles whose length is more than some hundred times
// their height. A ray that leaves such a sliver may meet it again, at t about 0. Nor does any offset help where another surface
// lies closer.
#pragma once

#include "libaccel/core/hit.h"
#include "libaccel/core/vec3d.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel {

struct SurfacePoint {
  Vec3 org;      // just above the surface, on the viewer's side
  Vec3d normal;  // the geometric normal, of unit length, facing the viewer
};

// The point where the ray with direction `dir` met the triangle, seen from the ray's side. For a triangle without area the
// normal is the direction back. `position_error` is that of the triangle's place, if it has one (geometry/triangle_source.h).
SurfacePoint offset_origin(const Triangle& triangle, const Hit& hit, Vec3 dir, double position_error = 0);

}  // namespace accel
