// The rays of a batch in another order, what it costs to have them so, and answers put back.
#pragma once

#include <cstdint>

#include "apps/common/measure.h"
#include "libaccel/packet/ray_order.h"

namespace accel::apps {

// Seconds for all rays of a batch: medians of several runs.
struct SortCost {
  double hash = 0, sort = 0;
  double copy = 0;  // the rays into their new order, and the answers back

  double total() const { return hash + sort + copy; }
};

struct SortedRays {
  RayOrder order;
  Buffer<Ray> rays;
  SortCost cost;  // without the way back of the answers
};

Result<SortedRays> sorted_rays(std::span<const Ray> rays, const Aabb& bounds, const RayOrderOptions& options, int repeat);

// Answers to sorted rays in the order of the batch; adds what that took to the cost.
Answers unsorted(const Answers& answers, const RayOrder& order, int threads, SortCost& cost);

// How many answers differ in a bit.
std::uint64_t differences(const Answers& a, const Answers& b);

}  // namespace accel::apps
