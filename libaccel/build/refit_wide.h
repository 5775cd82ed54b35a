// Refits a Bvh8: the tree stays, triangles and boxes become those of vertices that have moved.
//
// Lext and Akenine-Moeller 2001, "Towards Rapid Reconstruction for Animated Ray Tracing"; Wald, Boulos and Shirley 2007, "Ray
// Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies". Level by level from the deepest up, all nodes of a
// level at once; the order of children (structure/bvh8.h) is found anew. Boxes are those of whole triangles, also where a
// spatial split had given a leaf a part only: the parts move in ways that a split does not know. So a refitted SBVH costs more
// than it did, even in place, and the first refit tells.
//
// Hits are right however the vertices move; how fast they are found is told by the cost, which only grows as triangles leave
// their neighbours: rebuild where it has grown by what a build is worth.
//
// O(n); boxes and triangles in parallel; the same for any number of threads. The refitted structure beside the old one, and 24
// bytes a block.
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/structure/bvh8.h"

namespace accel {

// Expected costs as of structure/bvh8_stats.h, before and after.
struct RefitCosts {
  double before = 0, after = 0;
};

struct RefittedBvh8 {
  Bvh8 structure;
  RefitCosts costs;
  double seconds = 0;
};

// The mesh has the triangles that the tree was built over, by number; only vertices differ, and its indices are in range. An
// error where it has not, where a coordinate is out of range (a build would leave the triangle out), and where a triangle that
// the build has left out can be hit now: the tree has no place for it (a triangle whose vertices were on one line may have
// gained an area by rounding; one with two equal vertices never does). Of the options, threads and costs are read.
Result<RefittedBvh8> refit_wide(const Bvh8& bvh, const TriangleMesh& mesh, const BuildOptions& options);

}  // namespace accel
