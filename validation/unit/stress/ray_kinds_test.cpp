#include "validation/stress/ray_kinds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "libaccel/core/vec3d.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

constexpr RayKind kKinds[] = {RayKind::mixed,         RayKind::at_vertices,    RayKind::beside_vertices,
                              RayKind::at_edges,      RayKind::beside_edges,   RayKind::in_split_planes,
                              RayKind::along_boxes,   RayKind::axis_parallel,  RayKind::from_surfaces,
                              RayKind::from_vertices, RayKind::from_planes,    RayKind::hit_at_t_min,
                              RayKind::hit_at_t_max,  RayKind::all_intervals,  RayKind::empty_intervals,
                              RayKind::any_length,    RayKind::denormal_parts, RayKind::in_triangles_planes,
                              RayKind::far_away,      RayKind::farther_away,   RayKind::not_rays};

class RayKinds : public testing::Test {
 protected:
  const TriangleMesh mesh = mesh_of(random_triangles(50, 0.3f, 1));
  std::vector<Ray> rays(RayKind kind, std::size_t count = 400) const { return rays_of_kind(kind, mesh, count, 1); }
};

// The share of the rays that have a property.
template <class Property>
double share(const std::vector<Ray>& rays, const Property& property) {
  return static_cast<double>(std::count_if(rays.begin(), rays.end(), property)) / static_cast<double>(rays.size());
}

TEST_F(RayKinds, AreTraceableButForThoseThatMustNotBe) {
  for (const RayKind kind : kKinds) {
    const bool traceable = kind != RayKind::empty_intervals && kind != RayKind::not_rays;
    EXPECT_GT(rays(kind).size(), 350u) << static_cast<int>(kind);
    EXPECT_EQ(share(rays(kind), is_traceable), traceable ? 1 : 0) << static_cast<int>(kind);
  }
}

TEST_F(RayKinds, DependOnTheSeedAndTheirNumber) {
  for (const RayKind kind : kKinds) {
    const std::vector<Ray> few = rays_of_kind(kind, mesh, 10, 7), other = rays_of_kind(kind, mesh, 10, 8);
    const auto same_org = [](const Ray& a, const Ray& b) { return a.org.x == b.org.x && a.dir.y == b.dir.y; };
    const std::vector<Ray> again = rays_of_kind(kind, mesh, 10, 7);
    if (kind == RayKind::not_rays) continue;  // NaN is not equal to itself
    EXPECT_TRUE(std::equal(few.begin(), few.end(), again.begin(), again.end(), same_org)) << static_cast<int>(kind);
    EXPECT_FALSE(std::equal(few.begin(), few.end(), other.begin(), other.end(), same_org)) << static_cast<int>(kind);
  }
}

TEST_F(RayKinds, MeetVerticesExactly) {
  std::set<std::tuple<float, float, float>> vertices;
  for (const Vec3& v : mesh.vertices) vertices.insert({v.x, v.y, v.z});
  const auto meets = [&](const Ray& ray) {
    const Vec3d end = Vec3d(ray.org) + Vec3d(ray.dir);
    return vertices.contains({static_cast<float>(end.x), static_cast<float>(end.y), static_cast<float>(end.z)});
  };
  EXPECT_GT(share(rays(RayKind::at_vertices), meets), 0.4);
  EXPECT_LT(share(rays(RayKind::beside_vertices), meets), 0.1);
  EXPECT_EQ(share(rays(RayKind::at_edges), meets), 0);
}

TEST_F(RayKinds, HaveZerosOfBothSigns) {
  for (const RayKind kind : {RayKind::axis_parallel, RayKind::in_split_planes, RayKind::along_boxes}) {
    const auto has = [](bool negative) {
      return [=](const Ray& r) {
        return std::any_of(&r.dir.x, &r.dir.x + 3, [=](float d) { return d == 0 && std::signbit(d) == negative; });
      };
    };
    EXPECT_GT(share(rays(kind), has(false)), 0.3);
    EXPECT_GT(share(rays(kind), has(true)), 0.3);
  }
}

TEST_F(RayKinds, HaveAllLengths) {
  double least = 1, most = 0;
  for (const Ray& ray : rays(RayKind::any_length, 2000)) {
    const double largest = std::max({std::fabs(ray.dir.x), std::fabs(ray.dir.y), std::fabs(ray.dir.z)});
    least = std::min(least, largest), most = std::max(most, largest);
  }
  EXPECT_LT(least, 1e-29);
  EXPECT_GT(most, 5e17);
}

TEST_F(RayKinds, HaveDenormalParts) {
  const auto has_denormal = [](const Ray& r) {
    return std::any_of(&r.dir.x, &r.dir.x + 3, [](float d) { return d != 0 && std::fabs(d) < 0x1p-126f; });
  };
  EXPECT_EQ(share(rays(RayKind::denormal_parts), has_denormal), 1);
}

}  // namespace
}  // namespace accel::validation
