#include "scenes/sphere_grid.h"

#include <gtest/gtest.h>

#include <map>
#include <utility>
#include <vector>

namespace accel {
namespace {

TEST(SphereGrid, IsClosedAndWindsOutwards) {
  for (const std::uint32_t frequency : {1u, 2u, 3u, 7u, 20u}) {
    const SphereGrid grid(frequency);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    std::vector<int> used(grid.vertices(), 0);
    for (std::uint32_t i = 0; i < grid.triangles(); ++i) {
      const IndexTriple t = grid.triangle(i);
      ASSERT_TRUE(t.v0 < grid.vertices() && t.v1 < grid.vertices() && t.v2 < grid.vertices()) << frequency << ' ' << i;
      const Vec3d a = grid.vertex(t.v0), b = grid.vertex(t.v1), c = grid.vertex(t.v2);
      EXPECT_GT(dot(cross(b - a, c - a), a + b + c), 0) << "triangle " << i << " of frequency " << frequency;
      ++edges[{t.v0, t.v1}], ++edges[{t.v1, t.v2}], ++edges[{t.v2, t.v0}];
      ++used[t.v0], ++used[t.v1], ++used[t.v2];
    }
    // Each directed edge occurs once and its reverse occurs too: closed and consistently wound.
    for (const auto& [edge, count] : edges) {
      EXPECT_EQ(count, 1);
      EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
    }
    for (const int count : used) EXPECT_GE(count, 4);
  }
}

TEST(SphereGrid, VerticesLieOnTheSphere) {
  const SphereGrid grid(13);
  for (std::uint32_t i = 0; i < grid.vertices(); ++i) EXPECT_NEAR(length(grid.vertex(i)), 1, 1e-14);
}

}  // namespace
}  // namespace accel
