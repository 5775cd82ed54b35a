#include "libaccel/exec/count_rays.h"

#include <tbb/combinable.h>

#include "libaccel/exec/cpu.h"

namespace accel {

Counters count_rays(const AnyTraverser::View& view, std::span<const Ray> rays, std::span<std::uint32_t> values, int threads,
                    RayCounter counter) {
  tbb::combinable<Counters> sums;
  for_each_block(rays.size(), threads, [&](std::size_t begin, std::size_t end) {
    Counters& sum = sums.local();
    AnyStates states(view, 1);
    AnyTraverser::State state = states[0];
    for (std::size_t i = begin; i < end; ++i) {
      StepObserver observer;
      Hit hit;
      const Phase phase = AnyTraverser::begin(view, rays[i], state, hit, observer);
      drive<AnyTraverser>(view, rays[i], state, hit, phase, observer);
      observer.counters.rays = 1;
      sum += observer.counters;
      if (!values.empty()) values[i] = static_cast<std::uint32_t>(value_of(observer.counters, counter));
    }
  });
  Counters total;
  sums.combine_each([&](const Counters& c) { total += c; });
  return total;
}

}  // namespace accel
