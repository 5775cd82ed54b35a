// SIMD against its scalar twin, on every target that the machine has.
#include "libaccel/packet/frustums_simd.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "validation/unit/packet/packets_on_targets.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

TEST(FrustumsSimd, FrustumsAreThoseOfTheScalarTwin) {
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh2 tree = test::octo_tree(mesh);
    if (tree.octo.empty()) continue;
    const test::PacketArrays arrays(mesh, tree);
    test::on_every_target([&, &scene = name] {
      std::vector<Frustum> frustums(arrays.frustums.size());
      make_frustums_simd(arrays.batch(tree), arrays.faces.data(), tree.bounds, frustums.data());
      for (std::size_t f = 0; f < frustums.size(); ++f)
        ASSERT_EQ(std::memcmp(&frustums[f], &arrays.frustums[f], sizeof(Frustum)), 0) << scene << packet_simd_target();
    });
  }
}

// Every kind of number that a coordinate of a direction can be, in all places, and rays that are none; not a whole number of
// vectors.
std::vector<Ray> rays_of_all_faces() {
  constexpr float kLeast = std::numeric_limits<float>::min();
  const float all[] = {0.0f,   -0.0f,   1,         -1,         0.5f,  kLeast,     -kLeast,
                       1e-40f, -1e-45f, 1.844e18f, -1.844e18f, 2e18f, -kInfinity, std::nanf("")};
  std::vector<Ray> rays = validation::invalid_rays();
  for (const float x : all)
    for (const float y : all)
      for (const float z : all) {
        rays.push_back({.org = {1, 2, 3}, .dir = {x, y, z}});
        rays.push_back({.org = {x, y, z}, .t_min = y, .dir = {1, -2, 1}, .t_max = x});
      }
  if (rays.size() % 4 == 0) rays.pop_back();
  return rays;
}

TEST(FrustumsSimd, FacesAreThoseOfTheScalarTwin) {
  const std::vector<Ray> rays = rays_of_all_faces();
  std::vector<std::uint8_t> expected;
  for (const Ray& ray : rays) expected.push_back(static_cast<std::uint8_t>(face_of(ray)));
  EXPECT_EQ(std::set(expected.begin(), expected.end()).size(), kNoFace + 1) << "all faces are there, and none";
  test::on_every_target([&] {
    std::vector<std::uint8_t> faces(rays.size());
    find_faces_simd(rays.data(), rays.size(), faces.data());
    EXPECT_EQ(faces, expected) << packet_simd_target();
  });
}

}  // namespace
}  // namespace accel
