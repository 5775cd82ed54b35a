#include "libaccel/packet/packet_pipeline.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cstring>

#include "libaccel/exec/drive.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/bvh2_stack.h"
#include "validation/unit/packet/packets_of_rays.h"

namespace accel {
namespace {

std::vector<Ray> pipeline_rays(const TriangleMesh& mesh, const Aabb& bounds) {
  std::vector<Ray> rays;
  for (const auto& packet : test::packets_for(mesh, bounds, 4)) rays.insert(rays.end(), packet.begin(), packet.end());
  const auto hostile = validation::stress_rays(mesh, 500, 6);  // some have no face, some cannot be traced
  rays.insert(rays.end(), hostile.begin(), hostile.end());
  return rays;
}

template <Query kQuery>
Hit trace_singly(const Bvh2View& view, const Ray& ray) {
  NullObserver observer;
  return trace_ray<Bvh2Stack<Watertight, kQuery>>(view, ray, observer);
}

template <class Pipeline, Query kQuery>
PipelineCounts expect_single_hits(const Bvh2& tree, const std::vector<Ray>& rays, const PipelineOptions& options) {
  using Answer = typename Pipeline::Answer;
  const auto singly = [view = tree.view()](const Ray& ray) { return trace_singly<kQuery>(view, ray); };
  std::vector<Answer> expected(rays.size()), answers(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) store_answer(singly(rays[i]), expected[i]);
  Pipeline pipeline(tree.view(), options);
  PipelineCounts counts;
  for (const int threads : {1, 3}) {
    std::fill(answers.begin(), answers.end(), Answer{});
    tbb::task_arena(threads).execute([&] { pipeline.trace(rays, answers, singly); });
    EXPECT_EQ(std::memcmp(answers.data(), expected.data(), answers.size() * sizeof(Answer)), 0);
    counts = pipeline.counts();
  }
  return counts;
}

TEST(PacketPipeline, HitsAreThoseOfSingleRays) {
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    SCOPED_TRACE(name);
    const Bvh2 tree = test::octo_tree(mesh);
    const std::vector<Ray> rays = pipeline_rays(mesh, tree.bounds);
    for (const PipelineOptions& options :
         {PipelineOptions{}, PipelineOptions{.cell_fraction = 0.5f, .max_size = 37, .min_size = 8, .budget = 20}}) {
      expect_single_hits<PacketPipeline<Query::closest>, Query::closest>(tree, rays, options);
      expect_single_hits<PacketPipeline<Query::any>, Query::any>(tree, rays, options);
      expect_single_hits<PacketPipeline<Query::any, 2>, Query::any>(tree, rays, options);
    }
  }
}

// Coherent rays of one face from one cell: packets of max_size, warps of 32, nothing alone.
TEST(PacketPipeline, CountsWhatItMakes) {
  TriangleMesh mesh;
  for (const auto& [name, candidate] : validation::stress_scenes())
    if (candidate.size() > mesh.size()) mesh = candidate;
  const Bvh2 tree = test::octo_tree(mesh);
  ASSERT_FALSE(tree.octo.empty());
  std::vector<Ray> rays;
  const Vec3 from = tree.bounds.lo - tree.bounds.extent(), to = (tree.bounds.lo + tree.bounds.hi) * 0.5f;
  for (int i = 0; i < 300; ++i) {
    rays.push_back({.org = from, .dir = to - from});
    rays.back().dir.x *= 1.5f + 1e-4f * static_cast<float>(i);
  }
  const std::uint32_t face = face_of(rays[0]);
  ASSERT_TRUE(std::all_of(rays.begin(), rays.end(), [&](const Ray& ray) { return face_of(ray) == face; }));
  rays.push_back({.org = from, .dir = {0, 0, 0}});
  const auto counts = expect_single_hits<PacketPipeline<Query::closest>, Query::closest>(tree, rays, {.max_size = 128});
  EXPECT_EQ(counts.rays, 301u);
  EXPECT_EQ(counts.chunks, 2u);
  EXPECT_EQ(counts.frustums, 3u);
  EXPECT_EQ(counts.alone, 1u);
  EXPECT_LE(counts.warp_rays, 300u);
  EXPECT_GE(32 * counts.warps, counts.warp_rays);
}

TEST(PacketPipeline, EveryStageTakesTime) {
  const auto scenes = validation::stress_scenes();
  const TriangleMesh& mesh = scenes.back().mesh;
  const Bvh2 tree = test::octo_tree(mesh);
  const std::vector<Ray> rays = pipeline_rays(mesh, tree.bounds);
  std::vector<Hit> hits(rays.size());
  PacketPipeline<Query::closest> pipeline(tree.view(), {.min_size = 4});
  pipeline.trace(rays, hits, [&](const Ray& ray) { return trace_singly<Query::closest>(tree.view(), ray); });
  double sum = 0;
  for (int s = 0; s < kPacketStages; ++s) {
    const auto stage = static_cast<PacketStage>(s);
    EXPECT_GT(pipeline.times().of(stage), 0) << name_of(stage);
    sum += pipeline.times().of(stage);
  }
  EXPECT_DOUBLE_EQ(pipeline.times().total(), sum);
}

}  // namespace
}  // namespace accel
