#include "apps/common/ambient.h"

namespace accel::apps {

Outcome<std::vector<float>> openness(const AnyAccel& accel, const PrimaryHits& from, float reach, int directions,
                                     std::uint64_t seed, int threads, ProgressBar& bar) {
  std::vector<float> open(from.hits.size(), 1.0f);
  std::vector<std::uint8_t> occluded;
  for (int d = 0; d < directions; ++d) {
    if (!bar.update("ambient light", static_cast<double>(d) / directions)) return Error{std::string(kInterrupted)};
    const auto set = ao_rays(from, reach, seed + static_cast<std::uint64_t>(d));
    if (!set) return set.error();
    occluded.resize(set->size());
    if (const Status traced = accel.occluded(set->rays.span(), occluded, {threads, {}}); !traced) return traced.error();

    // The set has one ray for every hit, in order.
    std::size_t next = 0;
    for (std::size_t i = 0; i < open.size(); ++i)
      if (from.hits[i].valid()) open[i] -= static_cast<float>(occluded[next++] != 0) / static_cast<float>(directions);
  }
  return open;
}

}  // namespace accel::apps
