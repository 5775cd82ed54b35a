#include "libaccel/build/kdtree_plane.h"

#include <tbb/parallel_for.h>

#include "libaccel/build/parallel.h"

namespace accel {
namespace {

KdPlane sweep_axis(const KdSet& set, int axis, const KdCosts& costs, double most) {
  const KdEventList& list = set.axis[axis];
  const double lo = set.cell.lo[axis], hi = set.cell.hi[axis];
  const int b = axis == 2 ? 0 : axis + 1, c = axis == 0 ? 2 : axis - 1;
  const double width = static_cast<double>(set.cell.hi[b]) - set.cell.lo[b],
               height = static_cast<double>(set.cell.hi[c]) - set.cell.lo[c];
  // The half area of a part of the cell is its length times half the perimeter, plus the area of the plane.
  const double rim = width + height, section = width * height;
  const double step = costs.traversal * half_area_in_double(set.cell), test = costs.intersection;
  const double bonus = 1 - costs.empty_bonus;

  KdPlane best;
  best.axis = axis;
  std::uint32_t below = set.size - list.starts, above = set.size;
  for (std::uint32_t i = 0; i < list.size; ++i) {
    const KdEvent event = list.events[i];
    const float position = position_of(event);
    // Of several events at one position the last end and the first start see the true counts, the others see more. A plane has
    // what starts there above it, and what ends there below it.
    const std::uint32_t start = is_start(event) ? 1 : 0;
    above -= 1 - start;
    const double lower = (position - lo) * rim + section, upper = (hi - position) * rim + section;
    double cost = step + test * (lower * below + upper * above);
    cost = below == 0 || above == 0 ? cost * bonus : cost;
    if (cost < most) {
      if (std::uint64_t{below} + above <= set.limit) {
        most = best.cost = cost, best.position = position;
      } else {
        best.is_limited = true;
      }
    }
    below += start;
  }
  return best;
}

}  // namespace

KdPlane cheapest_plane(const KdSet& set, const KdCosts& costs, double most) {
  KdPlane planes[3];
  if (set.size < kParallelSize) {
    for (int a = 0; a < 3; ++a) planes[a] = sweep_axis(set, a, costs, most);
  } else {
    tbb::parallel_for(0, 3, [&](int a) { planes[a] = sweep_axis(set, a, costs, most); });
  }
  KdPlane best = planes[0];
  for (int a = 1; a < 3; ++a)
    if (planes[a].cost < best.cost) best = planes[a];
  best.is_limited = planes[0].is_limited || planes[1].is_limited || planes[2].is_limited;
  return best;
}

}  // namespace accel
