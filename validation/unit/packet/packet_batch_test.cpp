// The pipeline that devices run, on the CPU's primitives, against single rays.
#include "libaccel/packet/packet_batch.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/exec/cpu.h"
#include "libaccel/geometry/moeller_trumbore.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/packet/cpu_primitives.h"
#include "libaccel/packet/serial_primitives.h"
#include "libaccel/rays/camera.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/trace/bvh2_stack.h"
#include "validation/unit/packet/packets_of_rays.h"

namespace accel {
namespace {

// The rays of a picture in rows, bundles, rays that hurt and rays that are none, all mixed.
std::vector<Ray> rays_for(const TriangleMesh& mesh, const Aabb& bounds) {
  const auto camera = Camera::make(default_camera(bounds), 60, 40);
  EXPECT_TRUE(camera) << camera.message();
  const auto primary = primary_rays(*camera);
  std::vector<Ray> rays(primary->rays.begin(), primary->rays.end());
  for (const auto& packet : test::packets_for(mesh, bounds, 4)) rays.insert(rays.end(), packet.begin(), packet.end());
  const auto invalid = validation::invalid_rays();
  for (std::size_t i = 0; i < invalid.size(); ++i) rays.insert(rays.begin() + static_cast<std::ptrdiff_t>(37 * i), invalid[i]);
  return rays;
}

template <class Primitives, class Test, Query kQuery, class Answer>
std::vector<Answer> traced(const Bvh2View& view, const std::vector<Ray>& rays, const PacketOptions& options,
                           std::size_t& singly) {
  Answer stale{};
  std::memset(static_cast<void*>(&stale), 0xab, sizeof stale);
  std::vector<Answer> answers(rays.size(), stale);
  const auto trace_singly = [&](const Ray* others, const std::uint32_t* ids, std::size_t count, Answer* block) {
    NullObserver observer;
    for (std::size_t i = 0; i < count; ++i)
      store_answer(trace_ray<Bvh2Stack<Test, kQuery>>(view, others[i], observer), block[ids[i]]);
    singly += count;
  };
  trace_packets<Primitives>(view, options, rays.data(), rays.size(), answers.data(), IntersectByRay<Primitives, Test, kQuery>{},
                            trace_singly);
  return answers;
}

template <class Test, class Primitives>
void expect_single_rays_answers(const Bvh2View& view, const std::vector<Ray>& rays, const PacketOptions& options,
                                std::size_t& singly) {
  std::vector<Hit> expected(rays.size());
  std::vector<std::uint8_t> blocked(rays.size());
  trace_closest<Bvh2Stack<Test, Query::closest>>(view, rays, expected, 1);
  trace_any<Bvh2Stack<Test, Query::any>>(view, rays, blocked, 1);
  const auto hits = traced<Primitives, Test, Query::closest, Hit>(view, rays, options, singly);
  EXPECT_TRUE(hits.empty() || std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)) == 0);
  EXPECT_EQ((traced<Primitives, Test, Query::any, std::uint8_t>(view, rays, options, singly)), blocked);
}

TEST(PacketBatch, HitsAreThoseOfSingleRaysWhateverThePackets) {
  const PacketOptions all[] = {{},
                               {.max_size = 1, .min_size = 1},
                               {.max_size = 512, .block_size = 1000},
                               {.max_size = 33, .min_size = 1, .block_size = 777, .cell_fraction = 0.1f},
                               {.max_width = 1e9f, .budget = 1000000},
                               {.budget = 0}};
  std::size_t packets_took_part = 0;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh2 tree = test::octo_tree(mesh);
    if (tree.root == kNoNode) continue;
    SCOPED_TRACE(name);
    const std::vector<Ray> rays = rays_for(mesh, tree.bounds);
    for (const PacketOptions& options : all) {
      std::size_t singly = 0;
      expect_single_rays_answers<Watertight, SerialPrimitives>(tree.view(), rays, options, singly);
      if (tree.octo.empty()) continue;
      if (options.budget == 1000000) {
        EXPECT_LT(singly, rays.size() / 2) << "of two queries: packets take part";
        ++packets_took_part;
      }
      if (options.budget == 0) {
        EXPECT_GT(singly, 0u) << "frustums give up";
      }
    }
    std::size_t singly = 0;
    expect_single_rays_answers<Watertight, CpuPrimitives>(tree.view(), rays, {}, singly);
    expect_single_rays_answers<MoellerTrumbore, SerialPrimitives>(tree.view(), rays, {}, singly);
  }
  EXPECT_GT(packets_took_part, 10u);
}

TEST(PacketBatch, ScenesWithoutTrianglesAndBatchesWithoutRays) {
  const Bvh2 empty = test::octo_tree({});
  const Bvh2 tree = test::octo_tree(validation::stress_scenes().back().mesh);
  std::size_t singly = 0;
  for (const std::size_t n : {0, 1, 31, 33, 300}) {
    const std::vector<Ray> rays(n, Ray{.org = {}, .dir = {0, 0, 1}});
    expect_single_rays_answers<Watertight, SerialPrimitives>(empty.view(), rays, {}, singly);
    expect_single_rays_answers<Watertight, SerialPrimitives>(tree.view(), rays, {}, singly);
    expect_single_rays_answers<Watertight, CpuPrimitives>(tree.view(), rays, {.min_size = 1}, singly);
  }
}

TEST(PacketKey, IsTheHashWithTheFaceFirst) {
  const Aabb bounds{{-1, -1, -1}, {1, 1, 1}};
  const PacketKey key{PacketKey::Hash::make(bounds, 0.01f)};
  const auto rays = random_rays(bounds, 3000);
  for (std::size_t i = 1; i < rays->rays.size(); ++i) {
    const Ray &a = rays->rays[i - 1], &b = rays->rays[i];
    EXPECT_EQ(PacketKey::face(key(a)), face_of(a));
    if (face_of(a) == face_of(b)) {
      EXPECT_EQ(key(a) < key(b), key.hash(a) < key.hash(b));
    } else {
      EXPECT_EQ(key(a) < key(b), face_of(a) < face_of(b));
    }
  }
  EXPECT_EQ(PacketKey::face(key(Ray{.org = {}, .dir = {}})), kNoFace);
}

}  // namespace
}  // namespace accel
