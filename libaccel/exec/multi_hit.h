// Runs a traverser with a test that collects (trace/multi_hit.h): the k nearest hits of rays, all of them or those behind a
// hit.
//
// One traversal a ray, which culls behind the k-th hit so far. Hits and their order are the same for every traverser of a
// structure, and for any number of threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "libaccel/exec/cpu.h"
#include "libaccel/trace/multi_hit.h"

namespace accel {

// Fills `hits`, which is not empty, with the nearest hits behind `after`, and returns how many there are.
// Traverser is one for the test Collect<...> and closest hits.
template <class Traverser, class Observer>
std::uint32_t collect_hits(const typename Traverser::View& view, const Ray& ray, HitPlace after, std::span<Hit> hits,
                           Observer& observer) {
  const Ray rest = behind(ray, after);
  HitBuffer buffer = HitBuffer::prepare(rest, after, hits.data(), static_cast<std::uint32_t>(hits.size()));
  if (!(after.t <= buffer.t_max)) return 0;  // behind a miss, or behind the ray's end
  StackOf<Traverser> stack;
  typename Traverser::State state{};
  attach_stack<Traverser>(state, stack);
  Hit hit;
  const Phase phase = Traverser::begin(view, rest, state, hit, observer);
  ray_data(state).buffer = &buffer;
  drive<Traverser>(view, rest, state, hit, phase, observer);
  return buffer.count;
}

// hits[i * k + j] is hit number j of rays[i], behind after[i] if `after` is not empty; counts[i] says how many there are, and
// the rest of the k are misses. k is the quotient of the sizes.
template <class Traverser>
void trace_hits(const typename Traverser::View& view, std::span<const Ray> rays, std::span<const Hit> after,
                std::span<Hit> hits, std::span<std::uint32_t> counts, int threads) {
  if (rays.empty()) return;
  const std::size_t k = hits.size() / rays.size();
  ACCEL_ASSERT(hits.size() == k * rays.size() && counts.size() == rays.size());
  for_each_block(rays.size(), threads, [&](std::size_t begin, std::size_t end) {
    NullObserver observer;
    for (std::size_t i = begin; i < end; ++i) {
      const std::span<Hit> out = hits.subspan(i * k, k);
      const HitPlace place = after.empty() ? kBeforeAllHits : place_of(after[i]);
      counts[i] = k == 0 ? 0 : collect_hits<Traverser>(view, rays[i], place, out, observer);
      std::fill(out.begin() + counts[i], out.end(), Hit{});
    }
  });
}

}  // namespace accel
