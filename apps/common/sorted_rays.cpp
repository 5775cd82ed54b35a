#include "apps/common/sorted_rays.h"

#include <algorithm>
#include <cstring>

namespace accel::apps {

namespace {

template <class Function>
double seconds_of(const Function& function) {
  return *timed([&]() -> Status { return function(), Done{}; });
}

template <class T>
std::uint64_t differences(std::span<const T> a, std::span<const T> b) {
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += std::memcmp(&a[i], &b[i], sizeof(T)) != 0;
  return count;
}

}  // namespace

Result<SortedRays> sorted_rays(std::span<const Ray> rays, const Aabb& bounds, const RayOrderOptions& options, int repeat) {
  SortedRays result;
  result.rays = Buffer<Ray>(rays.size());
  std::vector<double> hash, sort, copy;
  for (int r = 0; r < std::max(repeat, 1); ++r) {
    auto order = order_rays(rays, bounds, options);
    if (!order) return order.error();
    result.order = *std::move(order);
    hash.push_back(result.order.hash_seconds), sort.push_back(result.order.sort_seconds);
    copy.push_back(seconds_of([&] { gather_rays(rays, result.order.ids.span(), result.rays.span(), options.threads); }));
  }
  result.cost = {median(hash), median(sort), median(copy)};
  return result;
}

Answers unsorted(const Answers& answers, const RayOrder& order, int threads, SortCost& cost) {
  const bool closest = answers.occluded.empty();
  Answers result(closest ? Query::closest : Query::any, order.ids.size());
  cost.copy += seconds_of([&] {
    if (closest)
      scatter(answers.hits.span(), order.ids.span(), result.hits.span(), threads);
    else
      scatter(answers.occluded.span(), order.ids.span(), result.occluded.span(), threads);
  });
  return result;
}

std::uint64_t differences(const Answers& a, const Answers& b) {
  return differences(a.hits.span(), b.hits.span()) + differences(a.occluded.span(), b.occluded.span());
}

}  // namespace accel::apps
