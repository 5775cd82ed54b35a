// Moves what a handle's structure holds without building all of it anew: the triangles of meshes that deform, and instances.
//
//   auto frame = AnyAccel::build(mesh, "bvh8-fast/stream");
//   for (...) {
//     const auto moved = refit(*frame, mesh_of_this_frame);
//     frame = moved->costs.after < 1.3 * first_cost ? moved->accel : AnyAccel::build(mesh_of_this_frame, "bvh8-fast/stream");
//   }
//
//   auto world = AnyAccel::build(scene, "bvh8-instances/stream");
//   for (...) {
//     const auto placed = scene.with_instances(instances_of_this_frame);
//     if (!placed) ...
//     world = move_instances(*world, *placed);
//     if (!world) ...
//   }
//
// The kinds that CPUs trace fastest can do it: triangles move in a bvh8, instances in a bvh8-levels. Others are rebuilt.
#pragma once

#include "libaccel/build/refit_wide.h"
#include "libaccel/geometry/instanced_meshes.h"
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

// The scene's instances in place of those that were built, with the same method: any number of them, of the same meshes, which
// nobody has changed. Trees over meshes stay as they are; that over instances is built anew, so rays cost nearly what they cost
// after a build. An error for a structure of another kind than bvh8-levels, and as build/wide_instances.h says. `accel` stays
// as it is. Of the report, time, phases and memory are those of the move. What the first rays with some triangle tests wait for
// (AnyAccel::accepts()), they wait for once more.
Result<AnyAccel> move_instances(const AnyAccel& accel, const InstancedMeshes& scene, const BuildOptions& options = {});

}  // namespace accel
