#include "libaccel/build/fast_wide_bvh.h"

#include <algorithm>
#include <array>
#include <limits>
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

// Blocks ahead of the one that is made. Triangles that are neighbours on the curve may be anywhere in the mesh.
constexpr std::size_t kAhead = 8;
void prefetch(const TriangleMesh& mesh, const CurveOrder& order, const BlockRun& run) {
  for (std::uint32_t i = 0; i < run.count; ++i) __builtin_prefetch(&mesh.triangles[order[run.first + i]]);
}

// The prim_ids of a run, in their order; kNoHit, which is larger than all, behind them.
std::array<std::uint32_t, kBlockLanes> sorted_ids(const CurveOrder& order, const BlockRun& run) {
  std::array<std::uint32_t, kBlockLanes> ids;
  for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane) {
    const std::uint32_t id = order[run.first + (lane < run.count ? lane : 0)];
    ids[lane] = lane < run.count ? id : kNoHit;
  }
  static_assert(kBlockLanes == 4 && kNoHit == std::numeric_limits<std::uint32_t>::max());
  const auto sort_two = [&](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t low = std::min(ids[a], ids[b]), high = std::max(ids[a], ids[b]);
    ids[a] = low, ids[b] = high;
  };
  sort_two(0, 1), sort_two(2, 3), sort_two(0, 2), sort_two(1, 3), sort_two(1, 2);
  return ids;
}

// Triangles by prim_id, as other builders have them.
void make_block(const TriangleMesh& mesh, const std::array<std::uint32_t, kBlockLanes>& ids, TriangleBlock& block) {
  static constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  static constexpr Vec3 kNowhere{kNaN, kNaN, kNaN};
  Float4 vertex[3][kBlockLanes];
  for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane) {
    const bool has = ids[lane] != kNoHit;
    const IndexTriple t = mesh.triangles[has ? ids[lane] : 0];
    const std::uint32_t corners[3] = {t.v0, t.v1, t.v2};
    for (int i = 0; i < 3; ++i) vertex[i][lane] = load_point(*(has ? &mesh.vertices[corners[i]] : &kNowhere));
    block.prim_id[lane] = ids[lane];
  }
  for (int i = 0; i < 3; ++i) {
    Float4 axis[3];
    transpose(vertex[i], axis);
    for (int a = 0; a < 3; ++a) store(block.vertex[a][i], axis[a]);
  }
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
  }
  const std::size_t blocks = runs.empty() ? tree.leaves : runs.size();
  const auto run_of = [&](std::size_t b) {
    return runs.empty() ? BlockRun{tree.clusters[b].first, tree.clusters[b].second} : runs[b];
  };
  if (nodes->nodes.size() >= kLeafBit || blocks > kMaxBlocks)
    return Error{"the wide tree needs " + std::to_string(nodes->nodes.size()) + " nodes and " + std::to_string(blocks) +
                 " blocks of triangles, more than a reference can name; split the mesh"};

  Bvh8 wide;
  static_cast<Bvh8Words&>(wide) = {nodes->root, nodes->depth, count, bounds.boxes.aabb()};
  wide.nodes = nodes->nodes;
  wide.blocks = Buffer<TriangleBlock>(blocks);
  context.memory.add(collapse_clusters_bytes(tree, *nodes) + wide.blocks.size_bytes() + runs.size() * sizeof(BlockRun));
  context.begin_phase("blocks");
  for_chunks(0, blocks, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      if (b + kAhead < end) prefetch(context.mesh, order, run_of(b + kAhead));
      make_block(context.mesh, sorted_ids(order, run_of(b)), wide.blocks[b]);
    }
  });
  context.report.references = count;
  return wide;
}

}  // namespace

Result<Built<Bvh8>> FastWideBvh::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return run_build<Bvh8>(mesh, options, build_tree);
}

}  // namespace accel
