#include "libaccel/rays/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace accel {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

CameraDescription looking_down_z() { return {{0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 90, "front"}; }

TEST(Camera, PictureStartsAtTheUpperLeft) {
  const auto camera = Camera::make(looking_down_z(), 200, 100);
  ASSERT_TRUE(camera.ok());
  // With a vertical angle of 90 degrees the picture at distance 1 reaches from -1 to 1, and twice as far sideways.
  const Vec3 first = camera->ray(0, 0).dir, last = camera->ray(200, 100).dir;
  EXPECT_NEAR(first.x / -first.z, -2, 1e-6);
  EXPECT_NEAR(first.y / -first.z, 1, 1e-6);
  EXPECT_NEAR(last.x / -last.z, 2, 1e-6);
  EXPECT_NEAR(last.y / -last.z, -1, 1e-6);
  EXPECT_NEAR(camera->ray(100, 50).dir.z, -1, 1e-7);
  EXPECT_EQ(camera->ray(3, 4).org, (Vec3{0, 0, 5}));
}

TEST(Camera, DirectionsHaveUnitLength) {
  const auto camera = Camera::make({{1, 2, 3}, {-4, 0, 2}, {0.1f, 1, 0}, 60, ""}, 64, 48);
  ASSERT_TRUE(camera.ok());
  for (int i = 0; i < 64 * 48; ++i) {
    const Ray ray = camera->ray(i % 64 + 0.5, i / 64 + 0.5);
    EXPECT_NEAR(length(Vec3d(ray.dir)), 1, 1e-7);
    EXPECT_TRUE(is_traceable(ray));
  }
}

TEST(Camera, UpNeedNotBePerpendicular) {
  CameraDescription tilted = looking_down_z();
  tilted.up = {0, 3, -40};
  const auto a = Camera::make(looking_down_z(), 8, 8), b = Camera::make(tilted, 8, 8);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_NEAR(length(Vec3d(a->ray(1, 2).dir) - Vec3d(b->ray(1, 2).dir)), 0, 1e-6);
}

// The message of a camera that a change to a good description has spoilt; empty when it has not.
template <class Change>
std::string message_after(const Change& change) {
  CameraDescription c = looking_down_z();
  change(c);
  const auto camera = Camera::make(c, 8, 8);
  return camera.ok() ? std::string() : camera.message();
}

TEST(Camera, RefusesDegenerateDescriptions) {
  const auto contains = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  EXPECT_EQ(message_after([](CameraDescription&) {}), "");
  EXPECT_TRUE(contains(message_after([](CameraDescription& c) { c.eye = c.at; }), "same point"));
  EXPECT_TRUE(contains(message_after([](CameraDescription& c) { c.up = {0, 0, 7}; }), "parallel"));
  EXPECT_TRUE(contains(message_after([](CameraDescription& c) { c.up = {0, 0, -1}; }), "parallel"));
  EXPECT_TRUE(contains(message_after([](CameraDescription& c) { c.up = {0, 0, 0}; }), "zero"));
  EXPECT_TRUE(contains(message_after([](CameraDescription& c) { c.eye.y = kNan; }), "not finite"));
  EXPECT_TRUE(contains(message_after([](CameraDescription& c) { c.at.x = 1e30f; }), "out of range"));
  EXPECT_TRUE(contains(message_after([](CameraDescription& c) { c.eye = c.at; }), "camera 'front': "));
  for (const float angle : {0.0f, -1.0f, 180.0f, 1e9f, kNan})
    EXPECT_TRUE(contains(message_after([&](CameraDescription& c) { c.vfov_degrees = angle; }), "vfov")) << angle;
  EXPECT_FALSE(Camera::make(looking_down_z(), 0, 8).ok());
}

// Every corner of the box lies in the square picture of its default camera.
void expect_box_in_picture(const Aabb& box) {
  const CameraDescription description = default_camera(box);
  ASSERT_TRUE(Camera::make(description, 8, 8).ok());
  const Vec3d eye(description.eye), forward = normalized(Vec3d(description.at) - eye);
  const Vec3d right = normalized(cross(forward, Vec3d(description.up))), up = cross(right, forward);
  const double edge = std::tan(description.vfov_degrees * 0.5 * std::numbers::pi / 180) * (1 + 1e-5);
  for (int i = 0; i < 8; ++i) {
    const Vec3d corner((i & 1 ? box.hi : box.lo).x, (i & 2 ? box.hi : box.lo).y, (i & 4 ? box.hi : box.lo).z);
    const Vec3d way = corner - eye;
    EXPECT_GT(dot(way, forward), 0);
    EXPECT_LE(std::fabs(dot(way, right)), edge * dot(way, forward));
    EXPECT_LE(std::fabs(dot(way, up)), edge * dot(way, forward));
  }
}

TEST(DefaultCamera, ShowsTheWholeBox) {
  expect_box_in_picture({{-1, -1, -1}, {1, 1, 1}});
  expect_box_in_picture({{100, 0, -3}, {101, 50, -2}});
  expect_box_in_picture({{-1e15f, 0, 0}, {1e15f, 1, 1}});
  expect_box_in_picture({{0, 0, 0}, {1e-12f, 1e-13f, 0}});
}

TEST(DefaultCamera, CopesWithBoxesThatShowNothing) {
  EXPECT_TRUE(Camera::make(default_camera(Aabb{}), 8, 8).ok());
  EXPECT_TRUE(Camera::make(default_camera({{kNan, 0, 0}, {1, 1, 1}}), 8, 8).ok());
  EXPECT_TRUE(Camera::make(default_camera({{5000, 1, 1}, {5000, 1, 1}}), 8, 8).ok());
  EXPECT_TRUE(Camera::make(default_camera({{0, 0, 0}, {0, 0, 0}}), 8, 8).ok());
}

}  // namespace
}  // namespace accel
