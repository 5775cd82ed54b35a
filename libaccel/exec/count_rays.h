// Traces rays to count what they cost.
#pragma once

#include <cstdint>
#include <span>

#include "libaccel/exec/any_traverser.h"

namespace accel {

// values[i], when asked for (else empty), is one of the counters of rays[i]. On `threads` threads (0: all of the machine).
// May throw std::bad_alloc.
Counters count_rays(const AnyTraverser::View& view, std::span<const Ray> rays, std::span<std::uint32_t> values, int threads,
                    RayCounter counter = RayCounter::steps);

template <class Traverser>
Counters count_rays(const typename Traverser::View& view, std::span<const Ray> rays, std::span<std::uint32_t> values,
                    int threads, RayCounter counter = RayCounter::steps) {
  return count_rays(any_view<Traverser>(view), rays, values, threads, counter);
}

}  // namespace accel
