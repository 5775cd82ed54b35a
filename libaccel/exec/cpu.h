// Runs a traverser over a batch of rays on the CPU: one task a block of rays, oneTBB between them.
//
// With one thread, oneTBB is not involved: that is the honest single-threaded measurement. Results do not depend on the number
// of threads or on the block size.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstdint>
#include <span>
#include <type_traits>

#include "libaccel/core/threads.h"
#include "libaccel/exec/batch_settings.h"
#include "libaccel/exec/batch_traverser.h"
#include "libaccel/exec/drive.h"

namespace accel {

// Rays in one task: long enough to hide the cost of a task, short enough to balance a batch of some ten thousand rays.
inline constexpr std::size_t kRaysPerTask = 1024;

// Calls body(begin, end) for blocks of about `grain` of [0, count), on `threads` threads (0: all of the machine).
template <class Body>
void for_each_block(std::size_t count, int threads, const Body& body, std::size_t grain = kRaysPerTask) {
  if (threads == 1 || count <= grain) {
    if (count > 0) body(std::size_t{0}, count);
    return;
  }
  const auto run = [&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                      [&](const tbb::blocked_range<std::size_t>& r) { body(r.begin(), r.end()); });
  };
  if (threads == 0) return run();
  tbb::task_arena arena(arena_size(threads));
  arena.execute(run);
}

// Block by block: each task has its own buffers. May throw std::bad_alloc.
template <class Traverser, class Answer>
void trace_batch(const typename Traverser::View& view, std::span<const Ray> rays, std::span<Answer> answers,
                 const BatchSettings& settings) {
  const auto trace_singly = [&view](const Ray& ray) {
    NullObserver observer;
    return trace_ray<Traverser>(view, ray, observer);
  };
  using Batch = typename Traverser::template Batch<decltype(trace_singly)>;
  typename Batch::Options options;
  if constexpr (std::is_base_of_v<PacketOptions, decltype(options)>) static_cast<PacketOptions&>(options) = settings.packets;
  if (rays.size() < Batch::kFewestRays) {
    for (std::size_t i = 0; i < rays.size(); ++i) store_answer(trace_singly(rays[i]), answers[i]);
    return;
  }
  std::size_t rays_per_task = options.block_size;
  if constexpr (requires { Batch::rays_per_task(rays, options); }) rays_per_task = Batch::rays_per_task(rays, options);
  for_each_block(
      rays.size(), settings.threads,
      [&](std::size_t begin, std::size_t end) {
        Batch batch(view, options, trace_singly);
        batch.trace(rays.subspan(begin, end - begin), answers.subspan(begin, end - begin));
      },
      rays_per_task);
}

// One ray, for little more than its traversal takes.
template <class Traverser, class Answer>
void trace_one(const typename Traverser::View& view, const Ray& ray, Answer& answer) {
  if constexpr (BatchTraverser<Traverser>) {
    using Batch = typename Traverser::template Batch<detail::TraceSingly>;
    if constexpr (requires { Batch::trace_one(view, ray, answer); }) return Batch::trace_one(view, ray, answer);
  }
  NullObserver observer;
  store_answer(trace_ray<Traverser>(view, ray, observer), answer);
}

// hits[i] is what rays[i] meets first. Both spans have the same size.
template <class Traverser>
void trace_closest(const typename Traverser::View& view, std::span<const Ray> rays, std::span<Hit> hits,
                   const BatchSettings& settings) {
  ACCEL_ASSERT(rays.size() == hits.size());
  if constexpr (BatchTraverser<Traverser>) return trace_batch<Traverser>(view, rays, hits, settings);
  for_each_block(rays.size(), settings.threads, [&](std::size_t begin, std::size_t end) {
    NullObserver observer;
    for (std::size_t i = begin; i < end; ++i) hits[i] = trace_ray<Traverser>(view, rays[i], observer);
  });
}

// occluded[i] is 1 where rays[i] meets anything, else 0.
template <class Traverser>
void trace_any(const typename Traverser::View& view, std::span<const Ray> rays, std::span<std::uint8_t> occluded,
               const BatchSettings& settings) {
  ACCEL_ASSERT(rays.size() == occluded.size());
  if constexpr (BatchTraverser<Traverser>) return trace_batch<Traverser>(view, rays, occluded, settings);
  for_each_block(rays.size(), settings.threads, [&](std::size_t begin, std::size_t end) {
    NullObserver observer;
    for (std::size_t i = begin; i < end; ++i) store_answer(trace_ray<Traverser>(view, rays[i], observer), occluded[i]);
  });
}

}  // namespace accel
