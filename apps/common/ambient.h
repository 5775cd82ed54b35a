// How open the surroundings of hits are: ambient occlusion, for pictures.
#pragma once

#include <vector>

#include "apps/common/failure.h"
#include "apps/common/progress_bar.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/any_accel.h"

namespace accel::apps {

// For each primary ray that hits, the share of `directions` seeded cosine-weighted rays that meet nothing within
// `reach`; 1 for misses.
Outcome<std::vector<float>> openness(const AnyAccel& accel, const PrimaryHits& from, float reach, int directions,
                                     std::uint64_t seed, int threads, ProgressBar& bar);

}  // namespace accel::apps
