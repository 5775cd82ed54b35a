// The device against the CPU, bit for bit: every method, triangle test, query and launch policy. Skipped where there is no
// device.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <iterator>
#include <utility>
#include <vector>

#include "libaccel/exec/cuda/device_accel.h"
#include "libaccel/rays/camera.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/any_accel.h"
#include "scenes/procedural.h"

namespace accel {
namespace {

constexpr LaunchPolicy kPolicies[] = {LaunchPolicy::grid, LaunchPolicy::persistent, LaunchPolicy::multipass};
static_assert(std::size(kPolicies) == kLaunchPolicies);

// Why there is nothing to test on this machine; empty where there is.
std::string no_device() {
  const auto info = cuda_device_info();
  return info ? std::string() : info.message();
}

#define ACCEL_SKIP_WITHOUT_DEVICE() \
  if (const std::string reason = no_device(); !reason.empty()) GTEST_SKIP() << reason

// Random rays, rays at edges, rays along axes, and rays that hit nothing by definition, in a number that no block size divides.
std::vector<Ray> mixed_rays(const TriangleMesh& mesh) {
  Aabb bounds;
  for (const Vec3& v : mesh.vertices) bounds.extend(v);
  std::vector<Ray> rays;
  for (const RaySet& set : {*random_rays(bounds, 5000), *edge_rays(mesh, 5000)})
    rays.insert(rays.end(), set.rays.begin(), set.rays.end());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < 900; i += 3) {
    rays[i].dir = {i % 2 == 0 ? 0.0f : -0.0f, rays[i].dir.y, 0.0f};
    if (i % 5 == 0) rays[i].dir = {0, -0.0f, rays[i].dir.z};
  }
  for (std::size_t i = 0; i < 37; ++i) {
    Ray ray = rays[i * 7];
    if (i % 3 == 0) ray.dir = {0, 0, 0};
    if (i % 3 == 1) ray.t_max = -1;
    if (i % 3 == 2) ray.org.y = nan;
    rays.insert(rays.begin() + static_cast<std::ptrdiff_t>(i * 100), ray);
  }
  return rays;
}

TEST(Cuda, WithoutADeviceEveryCallSaysWhy) {
  const std::string reason = no_device();
  if (reason.empty()) GTEST_SKIP() << "there is a device";
  const std::vector<Ray> rays(3);
  EXPECT_EQ(DeviceBatch::upload(rays).message(), reason);
  const auto mesh = make_builtin("cornell");
  const auto accel = AnyAccel::build(mesh->mesh, "bvh/stack");
  EXPECT_EQ(DeviceAccel::upload(accel->structure(), "bvh/stack").message(), reason);
}

TEST(Cuda, DescribesTheDevice) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  const auto info = cuda_device_info();
  EXPECT_FALSE(info->name.empty());
  EXPECT_GE(info->compute_major, 7);
  EXPECT_GT(info->multiprocessors, 0);
  EXPECT_GT(info->memory_bytes, 0u);
}

// Every launch policy on a batch that is on the device already. What a kernel leaves out is wrong: trace() spoils the answers
// of the trace before.
void expect_cpu_answers(const AnyAccel& cpu, const DeviceAccel& device, const DeviceBatch& batch, std::span<const Ray> rays,
                        const std::string& test) {
  std::vector<Hit> expected(rays.size()), hits(rays.size());
  std::vector<std::uint8_t> expected_any(rays.size()), any(rays.size());
  ASSERT_TRUE(cpu.closest(rays, expected, {.test = test}).ok());
  ASSERT_TRUE(cpu.occluded(rays, expected_any, {.test = test}).ok());
  for (const LaunchPolicy policy : kPolicies) {
    SCOPED_TRACE(cpu.method().name + " " + test + " " + policy_name(policy));
    const auto closest = device.trace(batch, Query::closest, {.policy = policy, .test = test});
    ASSERT_TRUE(closest.ok()) << closest.message();
    ASSERT_TRUE(batch.hits(hits).ok());
    EXPECT_EQ(std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)), 0);
    ASSERT_TRUE(device.trace(batch, Query::any, {.policy = policy, .test = test}).ok());
    ASSERT_TRUE(batch.occluded(any).ok());
    EXPECT_EQ(any, expected_any);
  }
}

class CudaScene : public testing::TestWithParam<const char*> {};

TEST_P(CudaScene, HitsAreTheCpusBitForBit) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  const auto scene = make_builtin(GetParam());
  ASSERT_TRUE(scene.ok()) << scene.message();
  const std::vector<Ray> rays = mixed_rays(scene->mesh);
  const auto batch = DeviceBatch::upload(rays);
  ASSERT_TRUE(batch.ok()) << batch.message();
  for (const MethodInfo& method : methods()) {
    const auto cpu = AnyAccel::build(scene->mesh, method.name);
    ASSERT_TRUE(cpu.ok()) << cpu.message();
    const auto device = DeviceAccel::upload(cpu->structure(), method.name);
    ASSERT_TRUE(device.ok()) << device.message();
    EXPECT_EQ(device->size_bytes(), cpu->size_bytes());
    for (const std::string& test : modelled_tests()) expect_cpu_answers(*cpu, *device, *batch, rays, test);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, CudaScene, testing::Values("soup:3000", "slivers:1000", "terrain:2000", "deep:1000"));

TEST(Cuda, SmallBatchesAndEmptyScenes) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  const TriangleMesh empty;
  const auto cpu = AnyAccel::build(empty, "bvh/stack");
  const auto device = DeviceAccel::upload(cpu->structure(), "bvh/stack");
  ASSERT_TRUE(device.ok()) << device.message();
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{31}, std::size_t{33}, std::size_t{129}}) {
    const std::vector<Ray> rays(count, Ray{.org = {}, .dir = {0, 0, 1}});
    const auto batch = DeviceBatch::upload(rays);
    ASSERT_TRUE(batch.ok()) << batch.message();
    for (const LaunchPolicy policy : kPolicies) {
      ASSERT_TRUE(device->trace(*batch, Query::closest, {.policy = policy}).ok());
      std::vector<Hit> hits(count, Hit{.t = 1, .prim_id = 1});
      ASSERT_TRUE(batch->hits(hits).ok());
      for (const Hit& hit : hits) EXPECT_FALSE(hit.valid());
    }
  }
}

// Every rule, in one batch and in several.
TEST(Cuda, MultipassInBatches) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  const auto scene = make_builtin("soup:3000");
  const std::vector<Ray> rays = mixed_rays(scene->mesh);
  const auto cpu = AnyAccel::build(scene->mesh, "bvh/stack");
  const auto device = DeviceAccel::upload(cpu->structure(), "bvh/stack");
  const auto batch = DeviceBatch::upload(rays);
  std::vector<Hit> expected(rays.size()), hits(rays.size());
  std::vector<std::uint8_t> expected_any(rays.size()), any(rays.size());
  ASSERT_TRUE(cpu->closest(rays, expected).ok());
  ASSERT_TRUE(cpu->occluded(rays, expected_any).ok());
  for (int rule = 0; rule < kMultipassRules; ++rule) {
    for (const std::uint32_t batch_size : {1u << 22, 1000u}) {
      DeviceTraceOptions options{.policy = LaunchPolicy::multipass};
      options.multipass = {.rule = static_cast<MultipassRule>(rule), .batch_size = batch_size};
      ASSERT_TRUE(device->trace(*batch, Query::closest, options).ok());
      ASSERT_TRUE(batch->hits(hits).ok());
      EXPECT_EQ(std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)), 0);
      ASSERT_TRUE(device->trace(*batch, Query::any, options).ok());
      ASSERT_TRUE(batch->occluded(any).ok());
      EXPECT_EQ(any, expected_any);
    }
  }
}

// Coherent rays, which packets serve, among rays that they leave; in one block and in many.
TEST(Cuda, PacketsInBlocks) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  const auto scene = make_builtin("terrain:2000");
  const auto cpu = AnyAccel::build(scene->mesh, "sbvh/breadth-first");
  ASSERT_TRUE(cpu.ok()) << cpu.message();
  Aabb bounds;
  for (const Vec3& v : scene->mesh.vertices) bounds.extend(v);
  const auto camera = Camera::make(default_camera(bounds), 200, 150);
  const auto primary = primary_rays(*camera);
  std::vector<Ray> rays = mixed_rays(scene->mesh);
  rays.insert(rays.end(), primary->rays.begin(), primary->rays.end());
  const auto device = DeviceAccel::upload(cpu->structure(), "sbvh/breadth-first");
  ASSERT_TRUE(device.ok()) << device.message();
  const auto batch = DeviceBatch::upload(rays);
  std::vector<Hit> expected(rays.size()), hits(rays.size());
  std::vector<std::uint8_t> expected_any(rays.size()), any(rays.size());
  ASSERT_TRUE(cpu->closest(rays, expected).ok());
  ASSERT_TRUE(cpu->occluded(rays, expected_any).ok());
  for (const auto& [block, queues] :
       {std::pair(1u << 22, false), {10000u, false}, {777u, false}, {1u << 22, true}, {777u, true}}) {
    const DeviceTraceOptions options{.packet_block = block, .packet_queues = queues};
    const auto closest = device->trace(*batch, Query::closest, options);
    ASSERT_TRUE(closest.ok()) << closest.message();
    ASSERT_TRUE(batch->hits(hits).ok());
    EXPECT_EQ(std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)), 0) << block;
    ASSERT_TRUE(device->trace(*batch, Query::any, options).ok());
    ASSERT_TRUE(batch->occluded(any).ok());
    EXPECT_EQ(any, expected_any) << block;
  }
}

TEST(Cuda, MistakesAreErrors) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  const auto mesh = make_builtin("cornell");
  const auto accel = AnyAccel::build(mesh->mesh, "bvh/stack");
  EXPECT_THAT(DeviceAccel::upload(accel->structure(), "bvh/stak").message(), testing::HasSubstr("bvh/stack"));
  EXPECT_THAT(DeviceAccel::upload(accel->structure(), "brute/loop").message(), testing::HasSubstr("'list'"));
  const auto device = DeviceAccel::upload(accel->structure(), "bvh/stack");
  const std::vector<Ray> rays(3);
  const auto batch = DeviceBatch::upload(rays);
  EXPECT_FALSE(device->trace(*batch, Query::closest, {.test = "watertite"}).ok());
  std::vector<Hit> too_few(2);
  EXPECT_FALSE(batch->hits(too_few).ok());
}

TEST(Cuda, TimesManyLaunches) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  const auto mesh = make_builtin("cornell");
  const auto accel = AnyAccel::build(mesh->mesh, "bvh/stack");
  const auto device = DeviceAccel::upload(accel->structure(), "bvh/stack");
  const std::vector<Ray> rays = mixed_rays(mesh->mesh);
  const auto batch = DeviceBatch::upload(rays);
  const auto timing = device->trace(*batch, Query::closest, {.warm_up = 2, .repeat = 5});
  ASSERT_TRUE(timing.ok()) << timing.message();
  EXPECT_GT(timing->min_ms, 0.0f);
  EXPECT_LE(timing->min_ms, timing->median_ms);
  EXPECT_LE(timing->median_ms, timing->max_ms);
}

}  // namespace
}  // namespace accel
