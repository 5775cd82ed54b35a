#include "libaccel/build/wide_instances.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <tbb/task_arena.h>

#include "libaccel/build/collapse_wide.h"
#include "libaccel/build/instances.h"
#include "libaccel/core/threads.h"

namespace accel {
namespace {

struct Collapsed {
  TwoLevelBvh8 structure;
  std::uint64_t peak_bytes = 0;
};

Result<Collapsed> collapse(const TwoLevelBvh& binary, const BuildOptions& options) {
  std::vector<Bvh8> trees;
  std::vector<std::uint64_t> triangles;
  std::uint64_t held = binary.size_bytes(), peak_bytes = 0;
  for (std::size_t i = 0; i < binary.trees.size(); ++i) {
    const Bvh2 tree = binary.tree(i);
    BuildOptions of_tree = options;
    if (i == 0) of_tree.max_leaf_size = 1;  // instances that have a leaf each keep it
    auto wide = collapse_wide(tree, of_tree);
    if (!wide) return wide.error();
    peak_bytes = std::max(peak_bytes, held - tree.size_bytes() + collapse_peak_bytes(tree, *wide));
    held += wide->size_bytes();
    trees.push_back(*std::move(wide));
    triangles.push_back(binary.trees[i].triangles);
  }
  Buffer<Bvh8Instance> instances(binary.instances.size());
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const TwoLevelInstance& instance = binary.instances[i];
    instances[i] = {instance.to_object, kNoNode, instance.tree, instance.first_prim, 1};
  }
  auto joined = TwoLevelBvh8::join(trees, triangles, instances);
  if (!joined) return joined.error();
  peak_bytes = std::max<std::uint64_t>(peak_bytes, held + instances.size_bytes() + joined->size_bytes());
  return Collapsed{*std::move(joined), peak_bytes};
}

}  // namespace

Result<Built<TwoLevelBvh8>> WideInstances::build(const InstancedMeshes& scene, const BuildOptions& options) {
  auto binary = InstanceBuilder::build(scene, options);
  if (!binary) return binary.error();
  try {
    const auto start = std::chrono::steady_clock::now();
    tbb::task_arena arena(arena_size(options.threads));
    auto wide = arena.execute([&] { return collapse(binary->structure, options); });
    if (!wide) return wide.error();
    BuildReport report = std::move(binary->report);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    report.phases.push_back({"collapse", seconds});
    report.seconds += seconds;
    report.peak_bytes = std::max(report.peak_bytes, wide->peak_bytes);
    report.references = 0;
    for (std::size_t i = 1; i < wide->structure.trees.size(); ++i) report.references += wide->structure.trees[i].references;
    return Built<TwoLevelBvh8>{std::move(wide->structure), std::move(report)};
  } catch (const std::bad_alloc&) {
    return Error{"out of memory while collapsing trees over " + std::to_string(scene.instances().size()) + " instances"};
  }
}

}  // namespace accel
