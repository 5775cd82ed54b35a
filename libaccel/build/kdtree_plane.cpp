#include "libaccel/build/kdtree_plane.h"

#include "libaccel/build/parallel.h"

namespace accel {
namespace {

// The sweep along one axis.
class AxisSweep {
 public:
  AxisSweep(const KdSet& set, int axis, const KdCosts& costs, double most)
      : list_(set.axis[axis]),
        lo_(set.cell.lo[axis]),
        hi_(set.cell.hi[axis]),
        step_(costs.traversal * half_area_in_double(set.cell)),
        costs_(costs),
        bonus_(1 - costs.empty_bonus),
        limit_(static_cast<double>(set.limit)),
        most_(most),
        below_(static_cast<double>(set.size - list_.starts)),
        above_(static_cast<double>(set.size)) {
    const int b = axis == 2 ? 0 : axis + 1, c = axis == 0 ? 2 : axis - 1;
    const double width = static_cast<double>(set.cell.hi[b]) - set.cell.lo[b],
                 height = static_cast<double>(set.cell.hi[c]) - set.cell.lo[c];
    rim_ = width + height, section_ = width * height;
    best_.axis = axis;
  }

  // A side may be empty at the first event, if nothing is below it, and at the last one, if nothing is above. Between them no
  // event needs to ask.
  KdPlane run() {
    if (list_.size == 0) return best_;
    const bool first_may_be_empty = below_ == 0, last_may_be_empty = list_.ends() == above_;
    const std::uint32_t last = list_.size - 1;
    std::uint32_t i = 0;
    if (first_may_be_empty) visit<true>(list_.events[i++]);
    for (; i < last; ++i) visit<false>(list_.events[i]);
    if (i == last) last_may_be_empty ? visit<true>(list_.events[i]) : visit<false>(list_.events[i]);
    return best_;
  }

 private:
  // Of several events at one position the last end and the first start see the true counts, the others see more. A plane has
  // what starts there above it, and what ends there below it.
  template <bool kMayBeEmpty>
  void visit(const KdEvent& event) {
    constexpr double kStarts[] = {0, 1}, kEnds[] = {1, 0};
    const std::uint32_t is_start = event.word >> 31;
    const double position = event.position;
    above_ -= kEnds[is_start];
    // The half area of a part of the cell is its length times half the perimeter, plus the area of the plane.
    const double lower = (position - lo_) * rim_ + section_, upper = (hi_ - position) * rim_ + section_;
    double cost = step_ + lower * cost_of<kMayBeEmpty>(below_) + upper * cost_of<kMayBeEmpty>(above_);
    if (kMayBeEmpty && (below_ == 0 || above_ == 0)) cost *= bonus_;
    if (cost < most_) {
      if (below_ + above_ <= limit_) {
        most_ = best_.cost = cost, best_.position = event.position;
      } else {
        best_.is_limited = true;
      }
    }
    below_ += kStarts[is_start];
  }

  template <bool kMayBeEmpty>
  double cost_of(double count) const {
    return kMayBeEmpty ? costs_.of_leaf(count) : costs_.leaf + costs_.intersection * count;
  }

  const KdEventList& list_;
  const double lo_, hi_, step_;
  const KdCosts costs_;
  const double bonus_, limit_;
  double rim_, section_;  // half the perimeter and the area of a plane's part in the cell
  double most_, below_, above_;
  KdPlane best_;
};

}  // namespace

KdPlane cheapest_plane(const KdSet& set, const KdCosts& costs, double most) {
  KdPlane planes[3];
  for_each_axis(set.size, [&](int a) { planes[a] = AxisSweep(set, a, costs, most).run(); });
  KdPlane best = planes[0];
  for (int a = 1; a < 3; ++a)
    if (planes[a].cost < best.cost) best = planes[a];
  best.is_limited = planes[0].is_limited || planes[1].is_limited || planes[2].is_limited;
  return best;
}

}  // namespace accel
