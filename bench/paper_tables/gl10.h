// What is measured for Garanzha and Loop 2010, "Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray Tracing"
// [GL10]: gl10_measure.cpp makes rays and takes the methods in turns, with a part in a file of its own for sorts, for frustums
// in trees and for the model of a GPU; gl10.cpp has the paper's figures and prints ours beside them.
//
// Speeds are those of a CPU, as ratios to depth-first single rays (sbvh/stack) on the same rays in the same run; what a GPU
// would make of the localized stage is told by the SIMT model (exec/simt.h). "To the letter" is packet/packet_pipeline.h, which
// takes the whole batch through the paper's stages; sbvh/breadth-first is what the library ships. All hits are compared bit for
// bit.
#pragma once

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "bench/paper_tables/paper_tables.h"
#include "libaccel/exec/simt_lanes.h"
#include "libaccel/packet/packet_pipeline.h"

namespace accel::paper_tables::garanzha_loop {

// Table 1: rays of a frustum at most, and cells as shares of the scene's diagonal.
inline constexpr std::uint32_t kMaxSizes[] = {128, 256, 512};
inline constexpr float kFractions[] = {0.002f, 0.004f, 0.008f, 0.016f};
inline constexpr std::size_t kSizeCount = std::size(kMaxSizes), kFractionCount = std::size(kFractions);

// The paper's: thousands of leaves and of frustums, and rays per warp.
struct PaperCell {
  double leaves, frustums, rays_per_warp;
};
using PaperTable = PaperCell[kSizeCount][kFractionCount];

struct SceneFigures {
  PaperScene scene;
  const PaperTable* table;  // or null, where the paper has none
  bool is_in_figure15;
};

// What is compared on the same rays. The first one is what the others are compared with.
enum Method { kStack, kBreadthFirst, kLiteral, kMethods };
inline constexpr const char* kMethodNames[kMethods] = {"sbvh/stack", "sbvh/breadth-first", "to the letter"};

// How frustums are taken through trees, from the one that ships on.
enum Walk { kOcto, kOctoDepth, kOctoScalar, kOctoScalarDepth, kBinary, kBinaryDepth, kWalks };
inline constexpr const char* kWalkNames[kWalks] = {
    "octo", "octo/depth-first", "octo/scalar", "octo/scalar/depth-first", "binary/scalar", "binary/scalar/depth-first"};

// What the SIMT model is asked. Localized intersection as in Fig. 10 goes through all leaves; any-hit queries end at a hit.
enum Model { kPrimary, kSoftShadow, kSoftShadowFig10, kModels };
inline constexpr const char* kModelNames[kModels] = {"primary", "soft shadow", "soft shadow, Fig. 10"};

// Which rays are sorted.
enum Sorted { kHitPoints, kSamples, kSorteds };
inline constexpr const char* kSortedNames[kSorteds] = {"hit points", "16 samples"};

struct Comparison {
  std::string rays;
  double mrays[kMethods] = {};
  StageTimes stages;  // medians
  PipelineCounts counts;

  double speed(Method m) const { return mrays[m] / std::max(mrays[kStack], 1e-9); }
};
struct GridCell {
  PipelineCounts counts;
  double mrays = 0;
};
struct SortTimes {
  std::size_t rays = 0, chunks = 0;
  double csd_ms = 0, plain_ms = 0;
};
struct WalkTimes {
  std::size_t frustums = 0, leaves = 0, binary_leaves = 0;
  double ms[kWalks] = {};
};
// What the lanes do in steps of a phase, where each has a ray: lanes, summed over steps.
struct LaneUse {
  std::uint64_t steps = 0, at_work = 0;
  std::uint64_t have_no_ray = 0;      // the packet's last warp is not full
  std::uint64_t are_answered = 0;     // an any-hit query that has met something
  std::uint64_t have_missed_box = 0;  // others test the triangles in it

  double share(std::uint64_t lanes) const {
    return static_cast<double>(lanes) / (32 * std::max<double>(1, static_cast<double>(steps)));
  }
};
struct ModelProfiles {
  SimtProfile localized, stack;  // of the same warps
  LaneUse boxes, triangles;      // of `localized`
  WarpProfile queues;            // of the same packets

  // The tests that rays make one by one, of all lanes in all steps of the warps with queues.
  double needed() const {
    const double tests = static_cast<double>(localized.descend.active_lanes + localized.intersect.active_lanes);
    return tests / std::max(1.0, 32 * static_cast<double>(issued(queues.simt)));
  }
};
struct SceneResult {
  bool is_stand_in = false;
  GridCell grid[kSizeCount][kFractionCount];
  std::vector<Comparison> comparisons;  // primary, soft shadows, and those of Figure 15
  SortTimes sorts[kSorteds];
  WalkTimes walks;
  ModelProfiles models[kModels];
};

Result<SceneResult> measure(const SceneFigures& figures, const Settings& settings);

// Compression-sorting-decompression and a plain radix sort, hashing included, of the keys of the pipeline.
Result<SortTimes> measure_sorts(std::span<const Ray> rays, const Aabb& bounds, const Settings& settings);

// Frustums through the tree's octo nodes and its binary ones, breadth first and depth first, on one thread.
Result<WalkTimes> measure_walks(const Bvh2View& view, const std::vector<Frustum>& frustums, const Settings& settings);

// The localized stage, a ray a lane and with queues, and single rays depth first in the warps of the former.
Result<ModelProfiles> run_model(Query query, const LocalizedBatch& batch, const Bvh2View& view);

}  // namespace accel::paper_tables::garanzha_loop
