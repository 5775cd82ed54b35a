#include "libaccel/build/wide_sbvh.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <string>
#include <utility>

#include <tbb/task_arena.h>

#include "libaccel/build/collapse_wide.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/core/threads.h"

namespace accel {

Result<Built<Bvh8>> WideSbvh::build(const TriangleMesh& mesh, const BuildOptions& options) {
  auto binary = Sbvh::build(mesh, options);
  if (!binary) return binary.error();
  try {
    const auto start = std::chrono::steady_clock::now();
    tbb::task_arena arena(arena_size(options.threads));
    Result<Bvh8> wide = arena.execute([&] { return collapse_wide(binary->structure, options); });
    if (!wide) return wide.error();
    BuildReport report = std::move(binary->report);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    report.phases.push_back({"collapse", seconds});
    report.seconds += seconds;
    report.references = wide->references;
    report.peak_bytes = std::max(report.peak_bytes, collapse_peak_bytes(binary->structure, *wide));
    return Built<Bvh8>{*std::move(wide), std::move(report)};
  } catch (const std::bad_alloc&) {
    return Error{"out of memory while collapsing a tree over " + std::to_string(mesh.size()) + " triangles"};
  }
}

}  // namespace accel
