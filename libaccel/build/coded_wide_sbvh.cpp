#include "libaccel/build/coded_wide_sbvh.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <string>
#include <utility>

#include <tbb/task_arena.h>

#include "libaccel/build/code_bvh8.h"
#include "libaccel/build/wide_sbvh.h"
#include "libaccel/core/threads.h"

namespace accel {
namespace {

template <class Node>
Result<Built<Bvh8Of<Node>>> build_coded(const TriangleMesh& mesh, const BuildOptions& options) try {
  auto exact = WideSbvh::build(mesh, options);
  if (!exact) return exact.error();
  const auto start = std::chrono::steady_clock::now();
  tbb::task_arena arena(arena_size(options.threads));
  Built<Bvh8Of<Node>> built{arena.execute([&] { return code_bvh8<Node>(exact->structure); }), std::move(exact->report)};
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  BuildReport& report = built.report;
  report.phases.push_back({"code boxes", seconds});
  report.seconds += seconds;
  report.peak_bytes =
      std::max<std::uint64_t>(report.peak_bytes, exact->structure.size_bytes() + built.structure.nodes.size_bytes());
  report.notes.push_back({"single-precision boxes", "coded in " + std::to_string(8 * sizeof(typename Node::Code)) +
                                                        " bits a plane, rounded outward: " + std::to_string(sizeof(Node)) +
                                                        " bytes a node instead of " + std::to_string(sizeof(Bvh8Node))});
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

}  // namespace accel
