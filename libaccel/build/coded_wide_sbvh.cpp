#include "libaccel/build/coded_wide_sbvh.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <string>
#include <utility>

#include <tbb/task_arena.h>

#include "libaccel/build/code_bvh8.h"
#include "libaccel/build/index_blocks.h"
#include "libaccel/build/wide_sbvh.h"
#include "libaccel/core/threads.h"

namespace accel {
namespace {

// Memory beside the tree with exact boxes.
template <class Node>
std::uint64_t coding_bytes(const Bvh8Of<Node>& bvh) {
  if constexpr (Node::Block::kIsIndexed)
    return bvh.size_bytes() + indexing_bytes(bvh.blocks.size());
  else
    return bvh.nodes.size_bytes();
}

// Without the vertex that is there to be read over, and the one that empty lanes name.
std::size_t count_vertices(const Bvh8Compact& bvh) {
  if (bvh.vertices.empty()) return 0;
  return bvh.vertices.size() - 1 - (bvh.references < kBlockLanes * bvh.blocks.size() ? 1 : 0);
}

BuildNote note_on_vertices(const Bvh8Compact& bvh) {
  return {"copies of vertices", "merged by position: " + std::to_string(count_vertices(bvh)) + " vertices for the " +
                                    std::to_string(bvh.references) + " triangles in the leaves, in " +
                                    std::to_string(bvh.blocks.size()) + " blocks of " + std::to_string(sizeof(IndexedBlock)) +
                                    " bytes instead of " + std::to_string(sizeof(TriangleBlock))};
}

template <class Node>
Result<Built<Bvh8Of<Node>>> build_coded(const TriangleMesh& mesh, const BuildOptions& options) try {
  auto exact = WideSbvh::build(mesh, options);
  if (!exact) return exact.error();
  const auto start = std::chrono::steady_clock::now();
  tbb::task_arena arena(arena_size(options.threads));
  Built<Bvh8Of<Node>> built{arena.execute([&] { return code_bvh8<Node>(exact->structure); }), std::move(exact->report)};
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  BuildReport& report = built.report;
  report.phases.push_back({Node::Block::kIsIndexed ? "code boxes, merge vertices" : "code boxes", seconds});
  report.seconds += seconds;
  report.peak_bytes = std::max(report.peak_bytes, exact->structure.size_bytes() + coding_bytes(built.structure));
  report.notes.push_back({"single-precision boxes", "coded in " + std::to_string(8 * sizeof(typename Node::Code)) +
                                                        " bits a plane, rounded outward: " + std::to_string(sizeof(Node)) +
                                                        " bytes a node instead of " + std::to_string(sizeof(Bvh8Node))});
  if constexpr (Node::Block::kIsIndexed) report.notes.push_back(note_on_vertices(built.structure));
  return built;
} catch (const std::bad_alloc&) {
  return Error{"out of memory while coding a tree over " + std::to_string(mesh.size()) + " triangles"};
}

}  // namespace

Result<Built<Bvh8Byte>> ByteWideSbvh::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return build_coded<ByteBvh8Node>(mesh, options);
}
Result<Built<Bvh8Half>> HalfWideSbvh::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return build_coded<HalfBvh8Node>(mesh, options);
}
Result<Built<Bvh8Compact>> CompactWideSbvh::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return build_coded<CompactBvh8Node>(mesh, options);
}

}  // namespace accel
