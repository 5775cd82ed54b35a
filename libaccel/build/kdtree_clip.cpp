#include "libaccel/build/kdtree_clip.h"

#include <algorithm>
#include <cmath>

#include "libaccel/geometry/clip_triangle.h"

namespace accel {

KdClipper::KdClipper(const TriangleMesh& mesh, const Aabb& scene) : mesh_(mesh) {
  double magnitude = 0;
  for (int a = 0; a < 3; ++a)
    magnitude = std::max({magnitude, std::abs(static_cast<double>(scene.lo[a])), std::abs(static_cast<double>(scene.hi[a]))});
  const Vec3d pad = cell_padding(scene);
  const double slack = 128 * 0x1p-53 * magnitude;
  reach_[0] = pad.x + slack, reach_[1] = pad.y + slack, reach_[2] = pad.z + slack;
}

void KdClipper::cut(std::uint32_t prim_id, const Aabb& cell, const KdPlane& plane, Reference (&parts)[2]) const {
  ClippedPolygon polygon(mesh_.triangle(prim_id));
  for (int a = 0; a < 3; ++a) polygon.clip(a, cell.lo[a] - reach_[a], cell.hi[a] + reach_[a]);
  for (int c = 0; c < 2; ++c) {
    const double sign = c == 0 ? -1 : 1;
    const ClippedPolygon::Bounds bounds = polygon.bounds_of_side(plane.axis, plane.position - sign * reach_[plane.axis], sign);
    Aabb child = cell;
    (c == 0 ? child.hi : child.lo)[plane.axis] = plane.position;
    Reference& part = parts[c];
    part.prim_id = prim_id, part.side = bounds.empty() ? kNowhere : 0;
    for (int a = 0; a < 3; ++a) {
      part.lo[a] = round_down(bounds.lo[a] - reach_[a]), part.hi[a] = round_up(bounds.hi[a] + reach_[a]);
      if (!(part.lo[a] < child.hi[a]) || !(part.hi[a] > child.lo[a])) part.side = kNowhere;
    }
  }
}

}  // namespace accel
