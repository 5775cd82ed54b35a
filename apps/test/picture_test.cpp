#include "apps/common/picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace accel::apps {
namespace {

RaySet rays_of_pixels(std::initializer_list<std::uint32_t> pixels) {
  RaySet set;
  set.rays = Buffer<Ray>(pixels.size());
  for (Ray& ray : set.rays) ray = Ray{{0, 0, 1}, 0, {0, 0, -1}};
  set.pixel = Buffer<std::uint32_t>::copy_of({pixels.begin(), pixels.size()});
  return set;
}

TriangleMesh facing_triangle() {
  TriangleMesh mesh;
  mesh.vertices = Buffer<Vec3>::copy_of(std::vector<Vec3>{{-1, -1, 0}, {-1, 1, 0}, {1, -1, 0}});  // wound away from the viewer
  mesh.triangles = Buffer<IndexTriple>::copy_of(std::vector<IndexTriple>{{0, 1, 2}});
  return mesh;
}

TEST(Picture, NumbersAreAveragedByPixel) {
  const std::vector<std::uint32_t> steps = {2, 4, 9};
  const HeatPicture picture = mean_by_pixel(steps, rays_of_pixels({0, 0, 2}), {3, 1});
  EXPECT_EQ(picture.values[0], 3);
  EXPECT_TRUE(std::isnan(picture.values[1]));  // no ray belongs to it
  EXPECT_EQ(picture.values[2], 9);
}

TEST(Picture, NormalsFaceTheViewer) {
  const std::vector<Hit> hits = {{1, 0.25f, 0.25f, 0}, {}};
  const ShadedPicture picture = shade(facing_triangle(), rays_of_pixels({0, 1}), hits, {2, 1});
  EXPECT_EQ(picture.surfaces[0].normal, (Vec3{0, 0, 1}));
  EXPECT_EQ(picture.surfaces[0].hit.prim_id, 0u);
  EXPECT_EQ(picture.surfaces[1].normal, Vec3{});
  EXPECT_FALSE(picture.surfaces[1].hit.valid());
}

TEST(Picture, ColoursAreAveragedAndCornersAreDarker) {
  const std::vector<Hit> hits = {{1, 0.25f, 0.25f, 0}, {1, 0.25f, 0.25f, 0}};
  const std::vector<float> open = {1, 0};
  const TriangleMesh mesh = facing_triangle();
  const ShadedPicture bright = shade(mesh, rays_of_pixels({0, 1}), hits, {2, 1}, open);
  EXPECT_GT(bright.colors[0].x, bright.colors[1].x);
  const ShadedPicture mixed = shade(mesh, rays_of_pixels({0, 0}), hits, {1, 1}, open);
  EXPECT_FLOAT_EQ(mixed.colors[0].x, 0.5f * (bright.colors[0].x + bright.colors[1].x));
}

TEST(Picture, ShrinkingAveragesWhatThereIs) {
  const float none = std::numeric_limits<float>::quiet_NaN();
  const HeatPicture small = shrunk(HeatPicture{{3, 2}, {1, 3, none, none, 2, none}, "title", "unit"}, 2);
  EXPECT_EQ(small.size.width, 2u);
  EXPECT_EQ(small.size.height, 1u);
  EXPECT_EQ(small.values[0], 2);
  EXPECT_TRUE(std::isnan(small.values[1]));
  EXPECT_EQ(shrunk(HeatPicture{{3, 2}, std::vector<float>(6, 1), {}, {}}, 3).size.width, 3u);  // fits already
}

TEST(Picture, ShrinkingKeepsTheGravestClass) {
  const ClassPicture picture{{4, 1}, {{"agree", {}}, {"miss", {}}, {"no rays", {}}}, {0, 1, 2, 2}, "title"};
  EXPECT_EQ(shrunk(picture, 2).values, (std::vector<std::uint8_t>{1, 2}));
  EXPECT_EQ(shrunk(picture, 1).values, (std::vector<std::uint8_t>{1}));
}

}  // namespace
}  // namespace accel::apps
