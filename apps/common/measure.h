// Timing: every engine traces the same rays, in turn, several times.
//
// Engines take turns within each repetition, and each repetition starts with another one, so that whatever slows the machine
// down for a while slows all of them. An untimed pass comes first; the answers of the last one are kept for the check.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/common/failure.h"
#include "apps/common/instructions.h"
#include "apps/common/progress_bar.h"
#include "libaccel/core/buffer.h"
#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/registry/any_accel.h"

namespace accel::apps {

// The answers to a batch: hits for closest-hit queries, flags for any-hit ones; the other stays empty.
struct Answers {
  Buffer<Hit> hits;
  Buffer<std::uint8_t> occluded;

  Answers() = default;
  Answers(Query query, std::size_t rays) : hits(query == Query::closest ? rays : 0), occluded(query == Query::any ? rays : 0) {}
};

// Something that traces: a method of the library, on whichever device, or the witness. The functions fill the answers and
// return the seconds that it took, by the clock that suits the device.
struct Engine {
  std::string name;
  std::function<Result<double>(std::span<const Ray>, std::span<Hit>)> closest;
  std::function<Result<double>(std::span<const Ray>, std::span<std::uint8_t>)> occluded;

  // What it traces in place of the batch, as many rays; empty: the batch.
  std::span<const Ray> own_rays = {};

  // Batches are cut into calls, so that progress is seen and interruptions are obeyed. The untimed pass finds the size.
  std::size_t rays_per_call = kFirstCall;

  static constexpr std::size_t kFirstCall = 1 << 12, kLongestCall = 1 << 20;
};

// Millions of rays a second.
struct Speed {
  double median = 0, least = 0, most = 0;
};

struct Measurement {
  // What a pass took: by the clock on the wall, and of all processors together.
  struct Pass {
    double seconds = 0, cpu_seconds = 0;
    std::optional<std::uint64_t> instructions;  // executed by this process, where they are counted
  };

  Speed speed;
  std::vector<Pass> passes;  // the timed ones
  Answers answers;

  // The median of the passes; nothing where they are not counted.
  std::optional<double> instructions() const;
};

// One measurement an engine, in their order. With no repetitions there are only answers. `counter`, unless null, counts
// instructions.
Outcome<std::vector<Measurement>> measure(std::span<Engine> engines, std::span<const Ray> rays, Query query, int repeat,
                                          ProgressBar& bar, const InstructionCounter* counter = nullptr);

// Of at least one value.
double median(std::vector<double> values);

// Runs a function that returns a Status and says how many seconds it took.
template <class Function>
Result<double> timed(const Function& function) {
  const auto start = std::chrono::steady_clock::now();
  if (const Status status = function(); !status) return status.error();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// A method of the library as an engine on the CPU. The engine shares the structure; the test's name must outlive it.
Engine engine_of(const AnyAccel& accel, const TraceOptions& options);

}  // namespace accel::apps
