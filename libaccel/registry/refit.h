// Moves the triangles of a handle's structure without building it anew: for meshes that deform.
//
//   auto frame = AnyAccel::build(mesh, "bvh8-fast/stream");
//   for (...) {
//     const auto moved = refit(*frame, mesh_of_this_frame);
//     frame = moved->costs.after < 1.3 * first_cost ? moved->accel : AnyAccel::build(mesh_of_this_frame, "bvh8-fast/stream");
//   }
//
// The kind that CPUs trace fastest can be refitted, the bvh8; others are rebuilt, and so are scenes whose instances move.
#pragma once

#include "libaccel/build/refit_wide.h"
#include "libaccel/registry/any_accel.h"

namespace accel {

struct RefittedAccel {
  AnyAccel accel;    // with the same method; the report is the build's
  RefitCosts costs;  // what rays are expected to cost, before and after: build/refit_wide.h
  double seconds = 0;
};

// `mesh` has the same triangles as the one that was built; vertices may be anywhere. An error where a structure of this kind
// cannot be refitted, where the number of triangles is another, and as build/refit_wide.h says. `accel` stays as it is.
Result<RefittedAccel> refit(const AnyAccel& accel, const TriangleMesh& mesh, const BuildOptions& options = {});

}  // namespace accel
