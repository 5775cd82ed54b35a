#include "libaccel/build/fast_wide_bvh.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "libaccel/build/balanced_wide.h"
#include "libaccel/build/cluster_tree.h"
#include "libaccel/build/collapse_clusters.h"
#include "libaccel/build/curve_leaves.h"
#include "libaccel/build/curve_order.h"
#include "libaccel/build/parallel.h"

namespace accel {
namespace {

// Triangles by prim_id, as other builders have them.
TriangleBlock make_block(const TriangleMesh& mesh, const CurveOrder& order, std::uint32_t first, std::uint32_t count) {
  std::uint32_t prim_ids[kBlockLanes];
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t id = order[first + i];
    std::uint32_t to = i;
    for (; to > 0 && id < prim_ids[to - 1]; --to) prim_ids[to] = prim_ids[to - 1];
    prim_ids[to] = id;
  }
  TriangleBlock block;
  for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane)
    if (lane < count)
      block.set(lane, pack(mesh.triangle(prim_ids[lane]), prim_ids[lane]));
    else
      block.clear(lane);
  return block;
}

Result<Bvh8> build_tree(BuildContext& context) {
  const References references = make_sparse_references(context);
  const std::size_t count = references.count;
  const SetBounds bounds = references.bounds;
  if (count == 0) return Bvh8{};
  const CurveOrder order = curve_order(context, references);
  const auto most = static_cast<std::uint32_t>(std::min<int>(context.options.max_leaf_size, kBlockLanes));

  ProgressMeter progress(context.options.progress, "merge", count);
  ClusterTree tree = cut_into_leaves(context, references, order, most);
  progress.advance(count - tree.leaves);
  merge_clusters(context, tree, bounds.boxes, progress);
  if (progress.stopped()) return Error{std::string(kInterrupted)};

  context.begin_phase("collapse");
  std::optional<WideNodes> nodes = collapse_clusters(tree, context.options);
  std::vector<BlockRun> runs;
  if (!nodes) {
    nodes = balanced_wide(in_order(references, order), context.options, runs);
  } else {
    runs.resize(tree.leaves);
    for (std::size_t i = 0; i < tree.leaves; ++i) runs[i] = {tree.clusters[i].first, tree.clusters[i].second};
  }
  if (nodes->nodes.size() >= kLeafBit || runs.size() > kMaxBlocks)
    return Error{"the wide tree needs " + std::to_string(nodes->nodes.size()) + " nodes and " + std::to_string(runs.size()) +
                 " blocks of triangles, more than a reference can name; split the mesh"};

  Bvh8 wide;
  static_cast<Bvh8Words&>(wide) = {nodes->root, nodes->depth, count, bounds.boxes.aabb()};
  wide.nodes = nodes->nodes;
  wide.blocks = Buffer<TriangleBlock>(runs.size());
  context.memory.add(collapse_clusters_bytes(tree, *nodes) + wide.blocks.size_bytes() + runs.size() * sizeof(BlockRun));
  context.begin_phase("blocks");
  for_chunks(0, runs.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b)
      wide.blocks[b] = make_block(context.mesh, order, runs[b].first, runs[b].count);
  });
  context.report.references = count;
  return wide;
}

}  // namespace

Result<Built<Bvh8>> FastWideBvh::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return run_build<Bvh8>(mesh, options, build_tree);
}

}  // namespace accel
