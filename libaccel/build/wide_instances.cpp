#include "libaccel/build/wide_instances.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <tbb/task_arena.h>

#include "libaccel/build/build_context.h"
#include "libaccel/build/collapse_wide.h"
#include "libaccel/build/instances.h"
#include "libaccel/build/top_level.h"
#include "libaccel/core/threads.h"

namespace accel {
namespace {

// Of the tree over instances, those that have a leaf each keep it.
Result<Bvh8> collapse_top(const Bvh2& top, const BuildOptions& options) {
  BuildOptions of_top = options;
  of_top.max_leaf_size = 1;
  return collapse_wide(top, of_top);
}

Error no_memory(const InstancedMeshes& scene, const char* doing) {
  return Error{std::string("out of memory while ") + doing + " " + std::to_string(scene.instances().size()) + " instances"};
}

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
    auto wide = i == 0 ? collapse_top(tree, options) : collapse_wide(tree, options);
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

// For each triangle of a mesh, where instances move: a frame is soon over.
constexpr double kBoxesPerTriangle = 1;

Status check_meshes(const TwoLevelBvh8& bvh, const InstancedMeshes& scene) {
  const std::size_t built = bvh.trees.empty() ? 0 : bvh.trees.size() - 1;
  if (scene.meshes().size() != built)
    return Error{"moving instances: the structure was built over " + std::to_string(built) + " meshes, but the scene has " +
                 std::to_string(scene.meshes().size()) + "; rebuild"};
  for (std::size_t i = 0; i < built; ++i)
    if (scene.meshes()[i].size() != bvh.trees[i + 1].triangles)
      return Error{"moving instances: mesh " + std::to_string(i + 1) + " had " + std::to_string(bvh.trees[i + 1].triangles) +
                   " triangles when it was built, but has " + std::to_string(scene.meshes()[i].size()) + "; rebuild"};
  return Done{};
}

Result<Built<TwoLevelBvh8>> replace_top(const TwoLevelBvh8& bvh, const InstancedMeshes& scene, const BuildOptions& options) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const std::size_t most = boxes_an_instance(scene, kBoxesPerTriangle);
  std::vector<std::vector<Aabb>> boxes;
  for (std::size_t i = 1; i < bvh.trees.size(); ++i)
    boxes.push_back(boxes_below(bvh.nodes.data(), bvh.trees[i].root, bvh.trees[i].bounds, most));
  const std::vector<AffineInverse> to_object = inverses(scene.instances());
  Result<Built<Bvh2>> binary = build_top_level(scene, to_object, boxes, options);
  if (!binary) return binary.error();
  const auto built = Clock::now();

  tbb::task_arena arena(arena_size(options.threads));
  const Result<Bvh8> top = arena.execute([&] { return collapse_top(binary->structure, options); });
  if (!top) return top.error();
  const auto collapsed = Clock::now();
  Buffer<Bvh8Instance> instances(to_object.size());
  for (std::size_t i = 0; i < instances.size(); ++i)
    instances[i] = {to_object[i], kNoNode, scene.instances()[i].mesh + 1, scene.first_prim(i), 1};
  Result<TwoLevelBvh8> moved = bvh.with_top(*top, instances);
  if (!moved) return moved.error();

  const auto seconds = [](Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
  };
  const auto end = Clock::now();
  BuildReport report;
  report.seconds = seconds(start, end);
  report.phases = {
      {"instances", seconds(start, built)}, {"collapse", seconds(built, collapsed)}, {"copy", seconds(collapsed, end)}};
  report.peak_bytes = std::max<std::uint64_t>(
      binary->report.peak_bytes, collapse_peak_bytes(binary->structure, *top) + instances.size_bytes() + moved->size_bytes());
  return Built<TwoLevelBvh8>{*std::move(moved), std::move(report)};
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
    return no_memory(scene, "collapsing trees over");
  }
}

Result<Built<TwoLevelBvh8>> move_instances(const TwoLevelBvh8& bvh, const InstancedMeshes& scene, const BuildOptions& options) {
  try {
    if (const Status good = validate(options); !good) return good.error();
    if (const Status good = check_meshes(bvh, scene); !good) return good.error();
    return replace_top(bvh, scene, options);
  } catch (const std::bad_alloc&) {
    return no_memory(scene, "moving");
  }
}

}  // namespace accel
