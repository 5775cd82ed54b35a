#include "libaccel/build/partition.h"

#include <algorithm>

namespace accel {

Partition partition_at_median(Reference* references, std::size_t begin, std::size_t end, const SetBounds& bounds) {
  Partition result;
  result.middle = begin + (end - begin + 1) / 2;
  const int axis = largest_axis((bounds.centers.hi - bounds.centers.lo).xyz());
  std::nth_element(references + begin, references + result.middle, references + end,
                   [axis](const Reference& a, const Reference& b) {
                     const float center_a = a.lo[axis] + a.hi[axis], center_b = b.lo[axis] + b.hi[axis];
                     return center_a < center_b || (center_a == center_b && a.prim_id < b.prim_id);
                   });
  result.side[0] = bounds_of(references, begin, result.middle);
  result.side[1] = bounds_of(references, result.middle, end);
  return result;
}

}  // namespace accel
