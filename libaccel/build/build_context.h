// What the phases of a build share: threads, progress and interruption, the memory held, and the report.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include <tbb/task_arena.h>

#include "libaccel/build/builder.h"
#include "libaccel/core/threads.h"

namespace accel {

// Counts the bytes that a build holds, and the most that it ever held. Thread-safe.
class MemoryMeter {
 public:
  void add(std::size_t bytes) {
    const std::uint64_t now = held_.fetch_add(bytes, std::memory_order_relaxed) + bytes;
    std::uint64_t peak = peak_.load(std::memory_order_relaxed);
    while (now > peak && !peak_.compare_exchange_weak(peak, now, std::memory_order_relaxed)) {
    }
  }
  void subtract(std::size_t bytes) { held_.fetch_sub(bytes, std::memory_order_relaxed); }
  std::uint64_t peak() const { return peak_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> held_{0}, peak_{0};
};

// Passes the work done on to the caller's Progress, from one thread at a time and ten times a second at most. Thread-safe.
class ProgressMeter {
 public:
  ProgressMeter(const Progress& progress, std::string_view phase, std::uint64_t total)
      : progress_(progress), phase_(phase), total_(total) {}

  // Tells that `amount` more of the total is done.
  void advance(std::uint64_t amount);
  // Whether the caller wants the build to stop. Tasks ask before they start.
  bool stopped() const { return stopped_.load(std::memory_order_relaxed); }

 private:
  const Progress& progress_;
  const std::string_view phase_;
  const std::uint64_t total_;
  std::atomic<std::uint64_t> done_{0};
  std::atomic<bool> stopped_{false};
  std::mutex mutex_;
  std::chrono::steady_clock::time_point last_{};
};

// Refuses options that mean nothing, with a message that names the option. NaN means nothing.
Status validate(const BuildOptions& options);

// One build. Phases run in `arena`; begin_phase() ends the one before.
class BuildContext {
 public:
  BuildContext(const TriangleMesh& mesh_to_build, const BuildOptions& build_options)
      : mesh(mesh_to_build), options(build_options), arena(arena_size(build_options.threads)) {}

  void begin_phase(std::string name);
  // Ends the last phase and closes the report.
  BuildReport finish();

  const TriangleMesh& mesh;
  const BuildOptions& options;
  tbb::task_arena arena;
  MemoryMeter memory;
  BuildReport report;

 private:
  using Clock = std::chrono::steady_clock;
  void end_phase();

  Clock::time_point start_ = Clock::now(), phase_start_ = start_;
};

// Runs a build in its context's arena and turns exhausted memory into an Error. `body` takes the context and returns a
// Result<Structure>.
template <class Structure, class Body>
Result<Built<Structure>> run_build(const TriangleMesh& mesh, const BuildOptions& options, Body body) {
  if (Status status = validate(options); !status) return status.error();
  try {
    BuildContext context(mesh, options);
    Result<Structure> structure = context.arena.execute([&] { return body(context); });
    if (!structure) return structure.error();
    return Built<Structure>{std::move(*structure), context.finish()};
  } catch (const std::bad_alloc&) {
    return Error{"out of memory while building a structure over " + std::to_string(mesh.size()) + " triangles"};
  }
}

}  // namespace accel
