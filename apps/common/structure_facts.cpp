#include "apps/common/structure_facts.h"

#include <algorithm>

#include "libaccel/registry/structures.h"
#include "libaccel/structure/bvh2_stats.h"
#include "libaccel/structure/bvh8_stats.h"
#include "libaccel/structure/grid_stats.h"
#include "libaccel/structure/kdtree_stats.h"
#include "libaccel/structure/two_level_stats.h"

namespace accel::apps {

namespace {

// End-point overlap takes microseconds a triangle: larger trees are sampled down to about this many.
constexpr std::uint64_t kMostOverlapTriangles = 200'000;

// Of a tree of boxes with leaves of triangles.
template <class Stats>
StructureFacts facts_from(const Stats& stats) {
  StructureFacts facts;
  facts.sah_cost = stats.sah_cost;
  facts.depth = stats.depth;
  facts.inner_nodes = stats.inner_nodes, facts.leaves = stats.leaves;
  facts.leaf_size_mean = stats.mean_leaf_size;
  facts.leaf_size_variance = stats.leaf_size_variance;
  facts.leaf_sizes = stats.leaves_by_size;
  facts.leaf_depths = stats.leaves_by_depth;
  while (!facts.leaf_sizes.empty() && facts.leaf_sizes.back() == 0) facts.leaf_sizes.pop_back();
  return facts;
}

// Leaves and their depths are those of the trees over meshes.
template <class Structure>
StructureFacts facts_of_levels(const Structure& bvh, const BuildOptions& options) {
  const auto stats = two_level_stats(bvh, options.traversal_cost, options.intersection_cost);
  StructureFacts facts = facts_from(stats.meshes);
  facts.sah_cost = stats.sah_cost;
  facts.depth = bvh.depth;
  return facts;
}
StructureFacts facts_of_kind(const TwoLevelBvh& bvh, const BuildOptions& options, Detail) {
  return facts_of_levels(bvh, options);
}
StructureFacts facts_of_kind(const TwoLevelBvh8& bvh, const BuildOptions& options, Detail) {
  return facts_of_levels(bvh, options);
}

StructureFacts facts_of_kind(const Bvh2& bvh, const BuildOptions& options, Detail detail) {
  const Bvh2Stats stats = bvh2_stats(bvh, options.traversal_cost, options.intersection_cost);
  StructureFacts facts = facts_from(stats);
  if (detail == Detail::all) {
    const auto stride = static_cast<std::uint32_t>(std::max<std::uint64_t>(stats.triangles / kMostOverlapTriangles, 1));
    facts.epo = end_point_overlap(bvh, options.traversal_cost, options.intersection_cost, stride);
  }
  return facts;
}

template <class Node>
StructureFacts facts_of_kind(const Bvh8Of<Node>& bvh, const BuildOptions& options, Detail) {
  return facts_from(bvh8_stats(bvh, options.traversal_cost, options.intersection_cost));
}

StructureFacts facts_of_kind(const Grid& grid, const BuildOptions& options, Detail) {
  const GridStats stats = grid_stats(grid, options.traversal_cost, options.intersection_cost);
  const GridResolution& cells = stats.resolution;
  StructureFacts facts;
  facts.sah_cost = stats.expected_cost;
  facts.resolution = std::to_string(cells.x) + " x " + std::to_string(cells.y) + " x " + std::to_string(cells.z);
  facts.empty_leaf_share = stats.empty_share();
  facts.references_per_triangle = stats.references_per_triangle();
  facts.leaf_size_mean = stats.mean_cell_size;
  facts.leaf_size_variance = stats.cell_size_variance;
  facts.leaf_sizes = stats.cells_by_size;
  while (!facts.leaf_sizes.empty() && facts.leaf_sizes.back() == 0) facts.leaf_sizes.pop_back();
  return facts;
}

StructureFacts facts_of_kind(const KdTree& tree, const BuildOptions& options, Detail) {
  const KdTreeStats stats = kdtree_stats(tree);
  StructureFacts facts;
  facts.sah_cost = stats.sah_cost(options.traversal_cost, options.intersection_cost);
  facts.expected_steps = stats.expected_steps, facts.expected_tests = stats.expected_tests;
  facts.depth = stats.depth;
  facts.inner_nodes = stats.inner_nodes, facts.leaves = stats.leaves;
  facts.leaf_size_mean = stats.mean_leaf_size;
  facts.leaf_size_variance = stats.leaf_size_variance;
  facts.leaf_sizes = stats.leaves_by_size;
  facts.leaf_depths = stats.leaves_by_depth;
  facts.references_per_triangle = stats.references_per_triangle();
  facts.empty_leaf_share =
      static_cast<double>(stats.empty_leaves) / static_cast<double>(std::max<std::uint64_t>(stats.leaves, 1));
  return facts;
}

// Structures of other kinds say at least how deep they are, if they are trees.
template <class Structure>
StructureFacts facts_of_kind(const Structure& structure, const BuildOptions&, Detail) {
  StructureFacts facts;
  if constexpr (requires { structure.depth; }) facts.depth = structure.depth;
  return facts;
}

template <class Structure>
StructureFacts facts_with_arrays(const Structure& structure, const BuildOptions& options, Detail detail) {
  StructureFacts facts = facts_of_kind(structure, options, detail);
  Structure::for_each_array(structure, [&](std::string_view name, const auto& array) {
    if (!array.empty()) facts.arrays.emplace_back(name, array.size_bytes());
  });
  return facts;
}

}  // namespace

StructureFacts facts_of(const AnyStructure& structure, const BuildOptions& options, Detail detail) {
  return visit_structure(structure, [&](const auto& s) { return facts_with_arrays(s, options, detail); })
      .value_or(StructureFacts{});
}

}  // namespace accel::apps
