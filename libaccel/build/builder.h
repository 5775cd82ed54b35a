// What a builder is, its options and its report.
//
// A builder is a type with
//
//   static constexpr const char* kName;      // the first half of a method's name: "bvh" in "bvh/stack"
//   using Structure = ...;                   // what it makes
//   static Result<Built<Structure>> build(const TriangleMesh&, const BuildOptions&);
//
// or, where the structure is one of instances, with a build() that takes InstancedMeshes (geometry/instanced_meshes.h). Other
// builders get the instances' triangles as one mesh, and builders of instances get a mesh as one instance at its place.
//
// All builders are parallel and deterministic: the same mesh and options give the same bytes for any number of threads. They
// accept any mesh that validate() accepts, drop triangles that no ray can hit (Skipped) and keep the caller's prim_id for all
// others.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libaccel/core/progress.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel {

// The largest that options may be.
inline constexpr int kMaxBins = 64;
inline constexpr int kMaxBuildDepth = 1024;  // inner nodes on a path: builders recurse
inline constexpr float kMaxDuplication = 15.0f;
inline constexpr float kMaxKdReferences = 1024.0f;
inline constexpr float kMaxGridDensity = 1e6f;
inline constexpr int kMaxReinsertionRounds = 1000;

struct BuildOptions {
  int threads = 0;  // 0: as many as the machine has

  // The cost model of the surface-area heuristic, in any unit: one step through a node (two boxes, or one plane), one triangle
  // test.
  float traversal_cost = 1.0f;
  float intersection_cost = 1.0f;

  int bins = 32;          // per axis, for object and spatial splits
  int max_leaf_size = 8;  // triangles; exceeded only where max_depth forbids more nodes
  int max_depth = 120;    // inner nodes on a path; kept always, by balanced splits where the heuristic would go deeper

  // Spatial splits (Stich et al. 2009, section 4): tried where the children of the best object split overlap by more than this
  // share of the root's area, as long as references stay below (1 + max_duplication) times the triangles. The paper's is 1e-5:
  // a quarter as much time again, for next to nothing once subtrees are reinserted. With 1e-3, what is small in a large scene
  // gets too few splits.
  float spatial_overlap = 1e-4f;
  float max_duplication = 0.5f;

  // Binary BVHs, and what is collapsed from them, may be improved by reinsertion (build/reinsertion.h), in so many rounds at
  // most; 0: not at all. After these seconds no round is begun; 0: no limit. With a limit, trees depend on how fast the machine
  // is.
  int reinsertion_rounds = 2;
  float reinsertion_seconds = 0.0f;

  // Kd-trees. They need bins and max_leaf_size for nothing: every plane is tried, and leaves end where the cost model says so.
  // Planes that cut off empty space are made cheaper by this share of their cost.
  float empty_bonus = 0.1f;
  // Most references in the leaves of kd-trees and grids, per triangle. Nodes share what there is in proportion to their
  // triangles.
  float max_references = 16.0f;

  // Grids: cells along each axis or, where they are 0, cells a triangle or, where that is 0 too, as many as the cost model
  // wants (build/grid.h).
  int grid_resolution[3] = {0, 0, 0};
  float grid_density = 0.0f;

  Progress progress;
};

// Triangles that a build left out, because no ray can hit them.
struct Skipped {
  std::uint64_t zero_area = 0;     // provably: the three vertices lie on a line
  std::uint64_t out_of_range = 0;  // a coordinate is not finite or beyond kMaxCoordinate
};

struct BuildPhase {
  std::string name;
  double seconds = 0;
};

// A decision of the build that users may want explained: something left out, or added for the method's sake.
struct BuildNote {
  std::string what;  // "parents and boxes"
  std::string why;   // "skipped: kdtree/stack does not read them"
};

struct BuildReport {
  double seconds = 0;              // wall time of the whole build
  std::vector<BuildPhase> phases;  // parts of it, in order
  Skipped skipped;
  std::vector<BuildNote> notes;
  std::uint64_t triangles = 0;   // in the structure, each counted once
  std::uint64_t references = 0;  // in the leaves; triangles * (1 + duplication)
  std::uint64_t peak_bytes = 0;  // the most memory that the build held at once, the finished structure included
};

template <class Structure>
struct Built {
  Structure structure;
  BuildReport report;
};

}  // namespace accel
