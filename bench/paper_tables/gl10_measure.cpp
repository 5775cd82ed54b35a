// Makes trees and rays for gl10, and measures methods and pipelines on them.
#include <tbb/task_arena.h>

#include <type_traits>

#include "bench/paper_tables/gl10.h"
#include "libaccel/core/threads.h"
#include "libaccel/exec/drive.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/trace/bvh2_stack.h"

namespace accel::paper_tables::garanzha_loop {

namespace {

// A tree, bound to both methods.
struct Tree {
  AnyAccel stack, breadth_first;

  Bvh2View view() const { return breadth_first.structure().get_if<Bvh2>()->view(); }
};

Result<Tree> make_tree(const TriangleMesh& mesh, const std::string& builder, const BuildOptions& options) {
  auto breadth_first = AnyAccel::build(mesh, builder + "/breadth-first", options);
  if (!breadth_first) return breadth_first.error();
  auto stack = breadth_first->with_method(builder + "/stack");
  if (!stack) return stack.error();
  return Tree{*std::move(stack), *std::move(breadth_first)};
}

// Section 4: leaves are nodes of ten triangles or less.
Result<Tree> make_paper_tree(const TriangleMesh& mesh, int threads) {
  return make_tree(mesh, "bvh", {.threads = threads, .traversal_cost = 1e6f, .max_leaf_size = 10, .reinsertion_rounds = 0});
}

// What all measurements of a scene have in common.
struct Stage {
  const TriangleMesh& mesh;
  const Tree& tree;
  const RaySet& primary;
  PrimaryHits from;
  LightDescription light;
  const Settings& settings;
};

// Soft-shadow rays towards a light `scale` times as large as the smallest one, which is a quarter as wide as the scene's.
constexpr float kSmallestLight = 0.25f;
Result<RaySet> soft_shadows(const Stage& stage, float scale, std::uint32_t samples) {
  LightDescription light = stage.light;
  light.half_u = light.half_u * (scale * kSmallestLight), light.half_v = light.half_v * (scale * kSmallestLight);
  return soft_shadow_rays(stage.from, light, 1, samples);
}

template <Query kQuery>
using Answers = std::vector<std::conditional_t<kQuery == Query::closest, Hit, std::uint8_t>>;

Status trace(const AnyAccel& accel, std::span<const Ray> rays, std::vector<Hit>& hits, int threads) {
  return accel.closest(rays, hits, {.threads = threads});
}
Status trace(const AnyAccel& accel, std::span<const Ray> rays, std::vector<std::uint8_t>& occluded, int threads) {
  return accel.occluded(rays, occluded, {.threads = threads});
}
template <Query kQuery, int kDirectionBits>
Status trace(PacketPipeline<kQuery, kDirectionBits>& pipeline, const Bvh2View& view, std::span<const Ray> rays,
             Answers<kQuery>& answers, int threads) {
  const auto trace_singly = [&](const Ray& ray) {
    NullObserver observer;
    return trace_ray<Bvh2Stack<Watertight, kQuery>>(view, ray, observer);
  };
  tbb::task_arena(arena_size(threads)).execute([&] { pipeline.trace(rays, answers, trace_singly); });
  return Done{};
}

template <class T>
Status store(Result<T> from, T& to) {
  if (!from) return from.error();
  to = *std::move(from);
  return Done{};
}

// Large batches are measured less often: their times vary less, and the machine is warm.
struct Turns {
  int untimed, timed;
};
Turns turns_for(std::size_t rays, const Settings& settings) {
  constexpr std::size_t kLarge = 1'000'000;
  return rays < kLarge ? Turns{1, settings.repeat} : Turns{0, std::min(settings.repeat, 3)};
}

StageTimes medians(const std::vector<StageTimes>& turns) {
  StageTimes result;
  for (int s = 0; s < kPacketStages; ++s) {
    std::vector<double> seconds;
    for (const StageTimes& turn : turns) seconds.push_back(turn.seconds[s]);
    result.seconds[s] = median(seconds);
  }
  return result;
}

// All methods in turns. All must give the same answers.
template <Query kQuery, int kDirectionBits>
Result<Comparison> compare(const std::string& name, const Tree& tree, std::span<const Ray> rays, const Settings& settings,
                           PacketPipeline<kQuery, kDirectionBits>& pipeline) {
  Comparison result{.rays = name};
  Answers<kQuery> expected(rays.size()), answers(rays.size());
  if (const Status s = trace(tree.stack, rays, expected, settings.threads); !s) return s.error();
  std::vector<double> times[kMethods];
  std::vector<StageTimes> stages;
  const auto [untimed, timed] = turns_for(rays.size(), settings);
  for (int turn = -untimed; turn < timed; ++turn) {
    for (int m = 0; m < kMethods; ++m) {
      const auto run = [&] {
        if (m == kLiteral) return trace(pipeline, tree.view(), rays, answers, settings.threads);
        return trace(m == kStack ? tree.stack : tree.breadth_first, rays, answers, settings.threads);
      };
      if (const Status s = time_ms(run, times[m]); !s) return s.error();
      if (!same_bits(answers, expected))
        return Error{name + ", " + kMethodNames[m] + ": its hits are not the stack version's, a bug"};
      if (turn < 0) times[m].clear();
    }
    if (turn >= 0) stages.push_back(pipeline.times());
  }
  for (int m = 0; m < kMethods; ++m) result.mrays[m] = mrays_of(rays.size(), median(times[m]));
  result.stages = medians(stages), result.counts = pipeline.counts();
  return result;
}

Status measure_primary(const Stage& stage, SceneResult& result) {
  const Bvh2View view = stage.tree.view();
  PacketPipeline<Query::closest> pipeline(view, {});
  auto comparison = compare("primary", stage.tree, stage.primary.rays.span(), stage.settings, pipeline);
  if (!comparison) return comparison.error();
  result.comparisons.push_back(*std::move(comparison));
  return store(run_model(Query::closest, pipeline.localized(), view), result.models[kPrimary]);
}

Status measure_soft_shadows(const Stage& stage, SceneResult& result) {
  const auto soft = soft_shadows(stage, 1, kSoftShadowSamples), points = soft_shadows(stage, 1, 1);
  if (!soft) return soft.error();
  if (!points) return points.error();
  const Bvh2View view = stage.tree.view();
  PacketPipeline<Query::any> pipeline(view, {});
  auto comparison = compare("soft shadow", stage.tree, soft->rays.span(), stage.settings, pipeline);
  if (!comparison) return comparison.error();
  result.comparisons.push_back(*std::move(comparison));

  const LocalizedBatch batch = pipeline.localized();
  Status s = store(run_model(Query::any, batch, view), result.models[kSoftShadow]);
  if (s) s = store(run_model(Query::closest, batch, view), result.models[kSoftShadowFig10]);
  if (s && view.octo_count > 0) s = store(measure_walks(view, pipeline.frustums(), stage.settings), result.walks);
  if (s) s = store(measure_sorts(points->rays.span(), view.bounds, stage.settings), result.sorts[kHitPoints]);
  if (s) s = store(measure_sorts(soft->rays.span(), view.bounds, stage.settings), result.sorts[kSamples]);
  return s;
}

// Table 1 and Figure 12, of one run each.
Status measure_grid(const Stage& stage, SceneResult& result) {
  const int threads = stage.settings.threads;
  const auto soft = soft_shadows(stage, 1, kSoftShadowSamples);
  if (!soft) return soft.error();
  const std::span<const Ray> rays = soft->rays.span();
  const auto tree = make_paper_tree(stage.mesh, threads);
  if (!tree) return tree.error();
  Answers<Query::any> expected(rays.size()), answers(rays.size());
  if (const Status s = trace(tree->stack, rays, expected, threads); !s) return s;
  for (std::size_t i = 0; i < kSizeCount; ++i)
    for (std::size_t f = 0; f < kFractionCount; ++f) {
      PacketPipeline<Query::any> pipeline(tree->view(), {.cell_fraction = kFractions[f], .max_size = kMaxSizes[i]});
      if (const Status s = trace(pipeline, tree->view(), rays, answers, threads); !s) return s;
      if (!same_bits(answers, expected))
        return Error{"packets of " + print("%u", kMaxSizes[i]) + " rays change hits, which is a bug"};
      result.grid[i][f] = {pipeline.counts(), mrays_of(rays.size(), 1e3 * pipeline.times().total())};
    }
  return Done{};
}

// Rays to larger lights are told apart by where they go, too.
template <int kDirectionBits>
Status add_figure15(const Stage& stage, float scale, std::uint32_t samples, SceneResult& result) {
  const auto set = soft_shadows(stage, scale, samples);
  if (!set) return set.error();
  PacketPipeline<Query::any, kDirectionBits> pipeline(stage.tree.view(), {});
  const std::string name = scale > 1 ? print("light x %g", scale) : print("%u sample%s", samples, samples > 1 ? "s" : "");
  auto comparison = compare(name, stage.tree, set->rays.span(), stage.settings, pipeline);
  if (!comparison) return comparison.error();
  result.comparisons.push_back(*std::move(comparison));
  return Done{};
}

Status measure_figure15(const Stage& stage, SceneResult& result) {
  for (const float scale : {2.0f, 4.0f})
    if (const Status s = add_figure15<2>(stage, scale, kSoftShadowSamples, result); !s) return s;
  for (const std::uint32_t samples : {4u, 1u})
    if (const Status s = add_figure15<0>(stage, 1, samples, result); !s) return s;
  return Done{};
}

}  // namespace

// Primary rays, and what starts from them, come along a Z-curve, as in section 4.
Result<SceneResult> measure(const SceneFigures& figures, const Settings& settings) {
  const auto scene = load(figures.scene, settings);
  if (!scene) return scene.error();
  const TriangleMesh& mesh = scene->data.mesh;
  const auto tree = make_tree(mesh, "sbvh", {.threads = settings.threads, .spatial_overlap = 1e-5f, .reinsertion_rounds = 0});
  if (!tree) return tree.error();
  auto primary = primary_rays(scene->data, settings.size, PixelOrder::z_curve);
  if (!primary) return primary.error();
  std::vector<Hit> hits(primary->size());
  if (const Status s = trace(tree->stack, primary->rays.span(), hits, settings.threads); !s) return s.error();
  const Stage stage{mesh, *tree, *primary, {mesh, *primary, hits}, light_of(scene->data), settings};

  SceneResult result{.is_stand_in = scene->is_stand_in};
  Status s = measure_primary(stage, result);
  if (s) s = measure_soft_shadows(stage, result);
  if (s && figures.table != nullptr) s = measure_grid(stage, result);
  if (s && figures.is_in_figure15) s = measure_figure15(stage, result);
  if (!s) return s.error();
  return result;
}

}  // namespace accel::paper_tables::garanzha_loop
