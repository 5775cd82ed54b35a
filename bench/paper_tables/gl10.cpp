// Garanzha and Loop 2010, "Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray Tracing" [GL10]: Table 1, Figures 12
// to 15, and what the text of section 5 compares: compression-sorting-decompression with a plain sort, breadth-first with
// depth-first traversal, the Octo-BVH with the binary tree.
//
// Speeds are those of a CPU, as ratios to depth-first single rays (sbvh/stack) on the same rays in the same run; what a GPU
// would make of the localized stage is told by the SIMT model (exec/simt.h). "To the letter" is packet/packet_pipeline.h, which
// takes the whole batch through the paper's stages; sbvh/breadth-first is what the library ships. All hits are compared bit for
// bit.
#include <algorithm>
#include <cstring>
#include <optional>
#include <span>
#include <type_traits>

#include <tbb/task_arena.h>

#include "bench/paper_tables/paper_tables.h"
#include "libaccel/core/threads.h"
#include "libaccel/exec/drive.h"
#include "libaccel/exec/simt.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/packet/depth_first.h"
#include "libaccel/packet/localized_ray.h"
#include "libaccel/packet/packet_pipeline.h"
#include "libaccel/packet/serial_primitives.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/trace/bvh2_stack.h"

namespace accel::paper_tables {

namespace {

constexpr std::uint32_t kMaxSizes[] = {128, 256, 512};
constexpr float kFractions[] = {0.002f, 0.004f, 0.008f, 0.016f};
constexpr std::size_t kSizeCount = std::size(kMaxSizes), kFractionCount = std::size(kFractions);

// Table 1: thousands of leaves and of frustums, and rays per warp, of this many million rays at most.
constexpr double kPaperMrays = 1024e-6 * 768 * kSoftShadowSamples;
struct PaperCell {
  double leaves, frustums, rays_per_warp;
};
using PaperTable = PaperCell[kSizeCount][kFractionCount];
constexpr PaperTable kConference = {{{859, 119, 30}, {691, 91, 30.9}, {618, 78, 31.7}, {640, 74, 31.9}},
                                    {{945, 116, 29}, {572, 62, 30.8}, {438, 44, 31.6}, {447, 39, 31.9}},
                                    {{792, 96, 29.5}, {431, 44, 31.0}, {303, 26, 31.6}, {294, 21, 31.9}}};
constexpr PaperTable kSponza = {{{721, 77, 30.8}, {610, 66, 31.4}, {557, 60, 31.8}, {546, 59, 31.9}},
                                {{512, 50, 30.9}, {378, 37, 31.5}, {318, 32, 31.8}, {303, 30, 31.9}},
                                {{494, 45, 30.8}, {283, 25, 31.5}, {189, 14, 31.8}, {171, 16, 31.9}}};

// The ratios that the text gives.
constexpr double kPaperSpeed = 3, kPaperCsd = 2, kPaperDepthFirst = 5, kPaperBinary = 2;

// The paper's scenes, and two rooms for its Fairy Forest, one of which stands for it in Figure 15, too.
struct SceneFigures {
  PaperScene scene;
  const PaperTable* table;
  bool is_in_figure15;
};
constexpr SceneFigures kScenes[] = {{{"BART Kitchen", "bart-kitchen", "builtin:soup:20000"}, nullptr, false},
                                    {{"Bathroom", "bathroom", "builtin:slivers:20000"}, nullptr, true},
                                    {{"Conference", "conference", "builtin:stadium:100000"}, &kConference, false},
                                    {{"Sponza", "sponza", "builtin:colonnade:66454"}, &kSponza, false}};

// What is compared on the same rays. The first one is what the others are compared with.
enum Method { kStack, kBreadthFirst, kLiteral, kMethods };
constexpr const char* kMethodNames[kMethods] = {"sbvh/stack", "sbvh/breadth-first", "to the letter"};

// How frustums are taken through trees, from the one that ships on.
enum Walk { kOcto, kOctoDepth, kOctoScalar, kOctoScalarDepth, kBinary, kBinaryDepth, kWalks };
constexpr const char* kWalkNames[kWalks] = {
    "octo", "octo/depth-first", "octo/scalar", "octo/scalar/depth-first", "binary/scalar", "binary/scalar/depth-first"};

// What the SIMT model is asked. Localized intersection as in Fig. 10 goes through all leaves; any-hit queries end at a hit.
enum Model { kPrimary, kSoftShadow, kSoftShadowFig10, kModels };
constexpr const char* kModelNames[kModels] = {"primary", "soft shadow", "soft shadow, Fig. 10"};

// Ours.
struct Comparison {
  std::string rays;
  double mrays[kMethods] = {};
  StageTimes stages;  // medians
  PipelineCounts counts;

  double speed(Method m) const { return mrays[m] / std::max(mrays[kStack], 1e-9); }
};
struct GridCell {
  PipelineCounts counts;
  double mrays = 0;
};
constexpr const char* kSortNames[] = {"hit points", "16 samples"};
struct SortTimes {
  std::size_t rays = 0, chunks = 0;
  double csd_ms = 0, plain_ms = 0;
};
struct SceneResult {
  bool is_stand_in = false;
  GridCell grid[kSizeCount][kFractionCount];
  std::vector<Comparison> comparisons;  // primary, soft shadows, and those of Figure 15
  SortTimes sorts[2];                   // of a ray for each hit point, and of all samples
  double walk_ms[kWalks] = {};
  std::size_t frustums = 0, leaves = 0, binary_leaves = 0;
  SimtProfile localized[kModels], stack[kModels];
};

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
  return make_tree(mesh, "bvh", {.threads = threads, .traversal_cost = 1e6f, .max_leaf_size = 10});
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

template <class Answer>
bool same(const std::vector<Answer>& a, const std::vector<Answer>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Answer)) == 0;
}

double mrays_of(std::size_t rays, double ms) { return 1e-3 * static_cast<double>(rays) / std::max(ms, 1e-6); }

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
      if (!same(answers, expected))
        return Error{name + ", " + kMethodNames[m] + ": its hits are not the stack version's, a bug"};
      if (turn < 0) times[m].clear();
    }
    if (turn >= 0) stages.push_back(pipeline.times());
  }
  for (int m = 0; m < kMethods; ++m) result.mrays[m] = mrays_of(rays.size(), median(times[m]));
  result.stages = medians(stages), result.counts = pipeline.counts();
  return result;
}

// Hashing included, of the keys of the pipeline.
Result<SortTimes> measure_sorts(std::span<const Ray> rays, const Aabb& bounds, const Settings& settings) {
  const auto hash = RayHash<std::uint32_t, 0>::make(bounds, PipelineOptions{}.cell_fraction);
  SortTimes result{.rays = rays.size()};
  std::vector<double> csd, plain;
  tbb::task_arena arena(arena_size(settings.threads));
  const auto sort = [&](bool compresses) {
    Buffer<std::uint32_t> keys(rays.size());
    CpuPrimitives::for_each(rays.size(), [&](std::size_t i) { keys[i] = hash(rays[i]); });
    if (!compresses) return plain_sort<CpuPrimitives>(keys.data(), keys.size());
    auto order = csd_sort<CpuPrimitives>(std::as_const(keys).data(), keys.size());
    result.chunks = order.chunks;
    return order.ids;
  };
  for (int turn = -1; turn < settings.repeat; ++turn) {
    Buffer<std::uint32_t> ours, theirs;
    const auto run = [&](bool compresses, Buffer<std::uint32_t>& ids, std::vector<double>& times) {
      return time_ms([&] { return arena.execute([&] { ids = sort(compresses); }), Status(Done{}); }, times);
    };
    if (const Status s = run(true, ours, csd); !s) return s.error();
    if (const Status s = run(false, theirs, plain); !s) return s.error();
    if (!std::equal(ours.begin(), ours.end(), theirs.begin(), theirs.end())) return Error{"sorts disagree, which is a bug"};
    if (turn < 0) csd.clear(), plain.clear();
  }
  result.csd_ms = median(csd), result.plain_ms = median(plain);
  return result;
}

// Frustums through trees, on one thread. Depth first finds what breadth first finds.
class Walks {
 public:
  Walks(const Bvh2View& view, const std::vector<Frustum>& frustums) : view_(view), frustums_(frustums) {
    budgets_.assign(frustums.size(), PipelineOptions{}.budget), gave_up_.resize(frustums.size());
  }

  Status measure(const Settings& settings, SceneResult& result) {
    result.frustums = frustums_.size();
    std::vector<double> times[kWalks];
    for (int turn = -1; turn < settings.repeat; ++turn) {
      if (const Status s = take_turn(times, result); !s) return s;
      if (turn >= 0) continue;
      for (auto& t : times) t.clear();
    }
    for (int w = 0; w < kWalks; ++w) result.walk_ms[w] = median(times[w]);
    return Done{};
  }

 private:
  Status take_turn(std::vector<double>* times, SceneResult& result) {
    Status s = pair(octo_, octo_depth_, times[kOcto], times[kOctoDepth], result.leaves);
    if (s) s = pair(octo_scalar_, octo_scalar_depth_, times[kOctoScalar], times[kOctoScalarDepth], result.leaves);
    if (s) s = pair(binary_, binary_depth_, times[kBinary], times[kBinaryDepth], result.binary_leaves);
    return s;
  }

  template <class Broad, class Deep>
  Status pair(Broad& broad, Deep& deep, std::vector<double>& broad_times, std::vector<double>& deep_times,
              std::size_t& leaves) {
    const typename Broad::Queue* queue = nullptr;
    const auto run_broad = [&] {
      queue = &broad.run(view_, frustums_.data(), frustums_.size(), budgets_.data(), gave_up_.data());
      return Status(Done{});
    };
    const typename Deep::Leaves* found = nullptr;
    const auto run_deep = [&] { return found = &deep.run(view_, frustums_.data(), frustums_.size()), Status(Done{}); };
    if (const Status s = time_ms(run_broad, broad_times); !s) return s;
    if (const Status s = time_ms(run_deep, deep_times); !s) return s;
    leaves = queue->count;
    const bool agree =
        std::equal(found->place.begin(), found->place.end(), queue->place.data(), queue->place.data() + leaves) &&
        std::equal(found->frustum.begin(), found->frustum.end(), queue->frustum.data());
    return agree ? Status(Done{}) : Error{"depth-first traversal finds other leaves, which is a bug"};
  }

  const Bvh2View view_;
  const std::vector<Frustum>& frustums_;
  std::vector<std::uint32_t> budgets_;
  std::vector<std::uint8_t> gave_up_;
  BreadthFirst<SerialPrimitives, SimdCulling> octo_;
  BreadthFirst<SerialPrimitives, ScalarCulling> octo_scalar_;
  BreadthFirst<SerialPrimitives, ScalarCullingOf<BinaryTree>, BinaryTree> binary_;
  DepthFirst<OctoTree, SimdChildren> octo_depth_;
  DepthFirst<OctoTree, ScalarChildren<OctoTree>> octo_scalar_depth_;
  DepthFirst<BinaryTree, ScalarChildren<BinaryTree>> binary_depth_;
};

// The model of a GPU: the localized stage, and single rays depth first in the very same warps. Of about kModelRays rays: every
// so many packets one is taken.
constexpr std::size_t kModelRays = 50'000;
template <Query kQuery>
Status run_model(const LocalizedBatch& batch, const Bvh2View& view, SimtProfile& localized, SimtProfile& stack) {
  std::size_t all = 0;
  for (std::size_t i = 0; i < batch.count; ++i) all += batch.packets[batch.active[i] + 1] - batch.packets[batch.active[i]];
  const std::size_t every = all / kModelRays + 1;
  std::vector<Ray> rays;
  std::vector<Hit> hits, expected;
  for (std::size_t i = 0; i < batch.count; i += every) {
    const std::uint32_t p = batch.active[i], first = batch.firsts[i];
    rays.clear();
    for (std::uint32_t at = batch.packets[p]; at < batch.packets[p + 1]; ++at) rays.push_back(batch.rays[batch.ids[at]]);
    hits.resize(rays.size()), expected.resize(rays.size());
    const PacketLeaves leaves{batch.nodes, batch.leaves, batch.places + first, batch.firsts[i + 1] - first};
    localized += simulate_simt<LocalizedRay<Watertight, kQuery>>(leaves, rays, hits, {.schedule = SimtSchedule::if_while}, 1);
    stack += simulate_simt<Bvh2Stack<Watertight, kQuery>>(view, rays, expected, {}, 1);
    const auto agree = [](const Hit& a, const Hit& b) {
      return kQuery == Query::any ? a.valid() == b.valid() : std::memcmp(&a, &b, sizeof a) == 0;
    };
    if (!std::equal(hits.begin(), hits.end(), expected.begin(), agree)) return Error{"the model's hits differ, which is a bug"};
  }
  return Done{};
}

// Soft-shadow rays towards a light `scale` times as large as the smallest one, which is a quarter as wide as the scene's.
constexpr float kSmallestLight = 0.25f;
Result<RaySet> soft_shadows(const PrimaryHits& from, LightDescription light, float scale, std::uint32_t samples) {
  light.half_u = light.half_u * (scale * kSmallestLight), light.half_v = light.half_v * (scale * kSmallestLight);
  return soft_shadow_rays(from, light, 1, samples);
}

// Rays to larger lights are told apart by where they go, too.
template <int kDirectionBits>
Status add_figure15(const Tree& tree, const PrimaryHits& from, const LightDescription& light, float scale,
                    std::uint32_t samples, const Settings& settings, SceneResult& result) {
  const auto set = soft_shadows(from, light, scale, samples);
  if (!set) return set.error();
  PacketPipeline<Query::any, kDirectionBits> pipeline(tree.view(), {});
  const std::string name = scale > 1 ? print("light x %g", scale) : print("%u sample%s", samples, samples > 1 ? "s" : "");
  auto comparison = compare(name, tree, set->rays.span(), settings, pipeline);
  if (!comparison) return comparison.error();
  result.comparisons.push_back(*std::move(comparison));
  return Done{};
}

Status measure_figure15(const Tree& tree, const PrimaryHits& from, const LightDescription& light, const Settings& settings,
                        SceneResult& result) {
  for (const float scale : {2.0f, 4.0f})
    if (const Status s = add_figure15<2>(tree, from, light, scale, kSoftShadowSamples, settings, result); !s) return s;
  for (const std::uint32_t samples : {4u, 1u})
    if (const Status s = add_figure15<0>(tree, from, light, 1, samples, settings, result); !s) return s;
  return Done{};
}

Status measure_primary(const Tree& tree, const RaySet& primary, const Settings& settings, SceneResult& result) {
  PacketPipeline<Query::closest> pipeline(tree.view(), {});
  auto comparison = compare("primary", tree, primary.rays.span(), settings, pipeline);
  if (!comparison) return comparison.error();
  result.comparisons.push_back(*std::move(comparison));
  return run_model<Query::closest>(pipeline.localized(), tree.view(), result.localized[kPrimary], result.stack[kPrimary]);
}

Status measure_soft_shadows(const Tree& tree, const PrimaryHits& from, const LightDescription& light, const Settings& settings,
                            SceneResult& result) {
  const auto soft = soft_shadows(from, light, 1, kSoftShadowSamples), points = soft_shadows(from, light, 1, 1);
  if (!soft) return soft.error();
  if (!points) return points.error();
  PacketPipeline<Query::any> pipeline(tree.view(), {});
  auto comparison = compare("soft shadow", tree, soft->rays.span(), settings, pipeline);
  if (!comparison) return comparison.error();
  result.comparisons.push_back(*std::move(comparison));
  const auto model = [&, batch = pipeline.localized()](auto query, Model m) {
    return run_model<query()>(batch, tree.view(), result.localized[m], result.stack[m]);
  };
  Status s = model(std::integral_constant<Query, Query::any>(), kSoftShadow);
  if (s) s = model(std::integral_constant<Query, Query::closest>(), kSoftShadowFig10);
  if (s && tree.view().octo_count > 0) s = Walks(tree.view(), pipeline.frustums()).measure(settings, result);
  if (!s) return s;

  const RaySet* const sets[] = {&*points, &*soft};
  for (int i = 0; i < 2; ++i) {
    const auto sorts = measure_sorts(sets[i]->rays.span(), tree.view().bounds, settings);
    if (!sorts) return sorts.error();
    result.sorts[i] = *sorts;
  }
  return Done{};
}

// Table 1 and Figure 12, of one run each.
Status measure_grid(const TriangleMesh& mesh, const PrimaryHits& from, const LightDescription& light, const Settings& settings,
                    SceneResult& result) {
  const auto soft = soft_shadows(from, light, 1, kSoftShadowSamples);
  if (!soft) return soft.error();
  const std::span<const Ray> rays = soft->rays.span();
  const auto tree = make_paper_tree(mesh, settings.threads);
  if (!tree) return tree.error();
  Answers<Query::any> expected(rays.size()), answers(rays.size());
  if (const Status s = trace(tree->stack, rays, expected, settings.threads); !s) return s;
  for (std::size_t i = 0; i < kSizeCount; ++i)
    for (std::size_t f = 0; f < kFractionCount; ++f) {
      PacketPipeline<Query::any> pipeline(tree->view(), {.cell_fraction = kFractions[f], .max_size = kMaxSizes[i]});
      if (const Status s = trace(pipeline, tree->view(), rays, answers, settings.threads); !s) return s;
      if (!same(answers, expected))
        return Error{"packets of " + print("%u", kMaxSizes[i]) + " rays change hits, which is a bug"};
      result.grid[i][f] = {pipeline.counts(), mrays_of(rays.size(), 1e3 * pipeline.times().total())};
    }
  return Done{};
}

// Primary rays, and what starts from them, come along a Z-curve, as in section 4.
Result<SceneResult> measure(const SceneFigures& figures, const Settings& settings) {
  const auto scene = load(figures.scene, settings);
  if (!scene) return scene.error();
  const auto tree = make_tree(scene->data.mesh, "sbvh", {.threads = settings.threads});
  if (!tree) return tree.error();
  auto primary = primary_rays(scene->data, settings.size, PixelOrder::z_curve);
  if (!primary) return primary.error();
  std::vector<Hit> hits(primary->size());
  if (const Status s = trace(tree->stack, primary->rays.span(), hits, settings.threads); !s) return s.error();
  const PrimaryHits from{scene->data.mesh, *primary, hits};
  const LightDescription light = light_of(scene->data);

  SceneResult result{.is_stand_in = scene->is_stand_in};
  Status s = measure_primary(*tree, *primary, settings, result);
  if (s) s = measure_soft_shadows(*tree, from, light, settings, result);
  if (s && figures.table != nullptr) s = measure_grid(scene->data.mesh, from, light, settings, result);
  if (s && figures.is_in_figure15) s = measure_figure15(*tree, from, light, settings, result);
  if (!s) return s.error();
  return result;
}

double per(double value, double of) { return value / std::max(of, 1e-9); }
double per(std::size_t value, std::size_t of) { return per(static_cast<double>(value), static_cast<double>(of)); }
double mega(std::size_t count) { return 1e-6 * static_cast<double>(count); }
double kilo(std::size_t count) { return 1e-3 * static_cast<double>(count); }

std::string title_of(const SceneResult& result, std::size_t s) { return title_of(kScenes[s].scene, result.is_stand_in); }

std::string table1(const std::vector<SceneResult>& results) {
  std::string text = paragraph(
      "Table 1: soft-shadow rays, 16 samples on an area light, a tree with ten triangles a leaf; thousands of "
      "leaves and of frustums per million rays; and Figure 12: the speed of the pipeline, to the letter",
      0, 2);
  TextTable table(
      {"UCF, MaxSize", "leaves", "paper", "frustums", "paper", "leaves/frustum", "paper", "rays/warp", "paper", "Mrays/s"});
  for (std::size_t s = 0; s < results.size(); ++s) {
    if (kScenes[s].table == nullptr) continue;
    table.add({title_of(results[s], s)});
    for (std::size_t i = 0; i < kSizeCount; ++i)
      for (std::size_t f = 0; f < kFractionCount; ++f) {
        const auto& [counts, mrays] = results[s].grid[i][f];
        const PaperCell& paper = (*kScenes[s].table)[i][f];
        table.add({print("  %g  %u", static_cast<double>(kFractions[f]), kMaxSizes[i]),
                   number(per(kilo(counts.leaves), mega(counts.rays))), number(paper.leaves / kPaperMrays),
                   number(per(kilo(counts.frustums), mega(counts.rays))), number(paper.frustums / kPaperMrays),
                   number(per(counts.leaves, counts.frustums)), number(paper.leaves / paper.frustums),
                   number(per(counts.warp_rays, counts.warps)), number(paper.rays_per_warp), number(mrays)});
      }
  }
  return text + table.text();
}

std::string figure13(const std::vector<SceneResult>& results) {
  std::string text =
      "\n" + paragraph("Figure 13: percentages of the stages, to the letter, and nanoseconds per ray in all", 0, 2);
  std::vector<std::string> titles = {"rays"};
  for (int s = 0; s < kPacketStages; ++s) titles.push_back(name_of(static_cast<PacketStage>(s)));
  titles.push_back("ns");
  TextTable table(titles);
  for (std::size_t s = 0; s < results.size(); ++s) {
    table.add({title_of(results[s], s)});
    for (const Comparison& c : results[s].comparisons) {
      std::vector<std::string> row = {" " + c.rays};
      for (const double seconds : c.stages.seconds) row.push_back(print("%.1f", 100 * per(seconds, c.stages.total())));
      row.push_back(number(per(1e9 * c.stages.total(), static_cast<double>(c.counts.rays))));
      table.add(row);
    }
  }
  return text + table.text();
}

std::string sort_table(const std::vector<SceneResult>& results) {
  std::string text =
      "\n" + paragraph("Compression, sorting and decompression (CSD) against a plain radix sort, hashing included", 0, 2);
  TextTable table({"rays", "M rays", "rays/chunk", "CSD ns/ray", "plain ns/ray", "plain/CSD", "paper"});
  for (std::size_t s = 0; s < results.size(); ++s)
    for (int i = 0; i < 2; ++i) {
      const SortTimes& t = results[s].sorts[i];
      const auto ns = [&](double ms) { return per(1e6 * ms, static_cast<double>(t.rays)); };
      table.add({title_of(results[s], s) + ", " + kSortNames[i], number(mega(t.rays)), number(per(t.rays, t.chunks)),
                 number(ns(t.csd_ms)), number(ns(t.plain_ms)), number(per(t.plain_ms, t.csd_ms)),
                 i == 0 ? "" : print("~%g", kPaperCsd)});
    }
  return text + table.text();
}

std::string walk_table(const std::vector<SceneResult>& results) {
  std::string text = "\n" + paragraph(
                                "The frustums of soft-shadow rays through trees, on one thread: times as multiples of that "
                                "of the Octo-BVH, breadth first, eight boxes at once in SIMD",
                                0, 2);
  TextTable table({"", "frustums", "leaves", "octo", "octo", "octo, scalar", "octo, scalar", "binary", "binary"});
  table.add({"", "k", "k", "breadth, ms", "depth", "breadth", "depth", "breadth", "depth"});
  for (std::size_t s = 0; s < results.size(); ++s) {
    const SceneResult& r = results[s];
    std::vector<std::string> row = {title_of(r, s), number(kilo(r.frustums)), number(kilo(r.leaves)), number(r.walk_ms[kOcto])};
    for (int w = kOcto + 1; w < kWalks; ++w) row.push_back(number(per(r.walk_ms[w], r.walk_ms[kOcto])));
    table.add(row);
  }
  table.add({"paper", "", "", "", print("%g", kPaperDepthFirst), "", "", print("%g", kPaperBinary), ""});
  return text + table.text();
}

std::string figures14_15(const std::vector<SceneResult>& results) {
  std::string text =
      "\n" + paragraph(
                 "Figures 14 and 15: the speed of depth-first single rays (sbvh/stack) in Mrays/s, and that of packets as "
                 "multiples of it, by sbvh/breadth-first and to the letter; the letter's frustums at UCF .004, MaxSize 256",
                 0, 2);
  TextTable table({"rays", "M rays", "stack", "breadth-first", "to the letter", "paper", "rays/frustum", "leaves/frustum"});
  for (std::size_t s = 0; s < results.size(); ++s) {
    table.add({title_of(results[s], s)});
    for (const Comparison& c : results[s].comparisons)
      table.add({"  " + c.rays, number(mega(c.counts.rays)), number(c.mrays[kStack]), number(c.speed(kBreadthFirst)),
                 number(c.speed(kLiteral)), c.rays == "soft shadow" ? print("~%g", kPaperSpeed) : "",
                 number(per(c.counts.rays, c.counts.frustums)), number(per(c.counts.leaves, c.counts.frustums))});
  }
  return text + table.text();
}

std::string simt_table(const std::vector<SceneResult>& results) {
  std::string text =
      "\n" + paragraph(
                 "The SIMT model's prediction for a GPU, in the same warps of rays of one packet: the localized stage against "
                 "depth-first single rays; steps a ray, lanes at work, and transactions (distinct sectors of 32 bytes)",
                 0, 2);
  TextTable table({"rays", "steps", "x stack", "lanes", "of boxes", "of triangles", "stack's", "sectors", "x stack"});
  for (std::size_t s = 0; s < results.size(); ++s) {
    table.add({title_of(results[s], s)});
    for (int m = 0; m < kModels; ++m) {
      const SimtProfile &ours = results[s].localized[m], &stack = results[s].stack[m];
      const double rays = std::max(1.0, static_cast<double>(ours.rays)), steps = static_cast<double>(issued(ours)),
                   sectors = static_cast<double>(all_traffic(ours).sectors);
      table.add({print("  %s", kModelNames[m]), number(kWarpSize * steps / rays),
                 number(per(steps, static_cast<double>(issued(stack)))), percent(ours.efficiency()),
                 percent(ours.descend.efficiency()), percent(ours.intersect.efficiency()), percent(stack.efficiency()),
                 number(sectors / rays), number(per(sectors, static_cast<double>(all_traffic(stack).sectors)))});
    }
  }
  return text + table.text();
}

std::string notes(const std::vector<SceneResult>& results, const Settings& settings) {
  std::string text = "\nWhere and why they differ\n";
  text += stand_in_note(std::any_of(results.begin(), results.end(), [](const SceneResult& r) { return r.is_stand_in; }));
  text += paragraph(
      "Scenes, views and lights are not the paper's: two rooms take the place of the Fairy Forest. The light is a quarter as "
      "wide "
      "as the library's default one, at which leaves per frustum are about those of the paper; \"x 4\" is the default light.");
  text +=
      paragraph(print("Pictures have %u x %u pixels, the paper's 1024 x 768: with fewer hit points in a cell, small cells "
                      "make small packets, more of them for each ray, and warps that are not full.",
                      settings.size, settings.size));
  text += paragraph(
      "Besides the cell of the origin, hash values have the face (dominant axis and sign), which frustums need; towards lights "
      "that are enlarged, cells within the face, too. Rays without a face are traced one by one (\"rest\").");
  text += paragraph(
      "On a CPU a stack lies in the nearest cache, while the queue of breadth-first traversal goes through memory once for "
      "each "
      "level, with the leaves found so far: depth-first traversal costs the paper's GPU five times as much, and less here. The "
      "binary tree is tested by scalar code; \"octo, scalar\" tells what part of the difference the arity has.");
  text += paragraph(
      "\"To the letter\" is sorted and taken through one stage after the other as a whole, so that each stage streams all rays "
      "through memory. sbvh/breadth-first takes blocks that fit the caches, sorts where it pays, and leaves wide frustums to "
      "single rays.");
  text += paragraph(
      "The model's warps go through the list of leaves together: all lanes test a box, then those that entered it its "
      "triangles. "
      "Sorting, frustums and traversal are not modelled. Any-hit rays that have met something idle until the last ray of their "
      "warp has; in Fig. 10, which has no such exit, all stay to the end.");
  return text;
}

Json row_named(const std::string& name, std::size_t s, const SceneResult& r) {
  return {{"name", std::string("gl10/") + kScenes[s].scene.file + "/" + name},
          {"run_type", "iteration"},
          {"scene", r.is_stand_in ? kScenes[s].scene.stand_in : kScenes[s].scene.file}};
}

void add_counts(const PipelineCounts& counts, Json& row) {
  row["rays"] = counts.rays, row["chunks"] = counts.chunks, row["frustums"] = counts.frustums, row["leaves"] = counts.leaves;
  row["rays_per_warp"] = per(counts.warp_rays, counts.warps), row["rays_alone"] = counts.alone;
}

void add_grid_rows(std::size_t s, const SceneResult& r, Json& rows) {
  if (kScenes[s].table == nullptr) return;
  for (std::size_t i = 0; i < kSizeCount; ++i)
    for (std::size_t f = 0; f < kFractionCount; ++f) {
      Json row = row_named(print("table 1/%g/%u", static_cast<double>(kFractions[f]), kMaxSizes[i]), s, r);
      add_counts(r.grid[i][f].counts, row);
      row["mrays_per_second"] = r.grid[i][f].mrays;
      const PaperCell& paper = (*kScenes[s].table)[i][f];
      row["paper_leaves"] = 1e3 * paper.leaves, row["paper_frustums"] = 1e3 * paper.frustums;
      row["paper_rays_per_warp"] = paper.rays_per_warp;
      rows.push_back(row);
    }
}

void add_speed_rows(std::size_t s, const SceneResult& r, Json& rows) {
  for (const Comparison& c : r.comparisons)
    for (int m = 0; m < kMethods; ++m) {
      Json row = row_named(c.rays + "/" + kMethodNames[m], s, r);
      row["mrays_per_second"] = c.mrays[m], row["ratio_to_stack"] = c.speed(static_cast<Method>(m));
      if (m == kLiteral) {
        add_counts(c.counts, row);
        for (int stage = 0; stage < kPacketStages; ++stage)
          row[std::string("seconds_") + name_of(static_cast<PacketStage>(stage))] = c.stages.seconds[stage];
      }
      rows.push_back(row);
    }
}

void add_other_rows(std::size_t s, const SceneResult& r, Json& rows) {
  for (int i = 0; i < 2; ++i) {
    const SortTimes& t = r.sorts[i];
    Json row = row_named(std::string("sort/") + kSortNames[i], s, r);
    row["rays"] = t.rays, row["chunks"] = t.chunks, row["csd_ms"] = t.csd_ms, row["plain_ms"] = t.plain_ms;
    rows.push_back(row);
  }
  for (int w = 0; w < kWalks; ++w) {
    Json row = row_named(std::string("traversal/") + kWalkNames[w], s, r);
    row["frustums"] = r.frustums, row["leaves"] = w < kBinary ? r.leaves : r.binary_leaves, row["ms"] = r.walk_ms[w];
    rows.push_back(row);
  }
  for (int m = 0; m < kModels; ++m)
    for (const bool is_stack : {false, true}) {
      const SimtProfile& p = is_stack ? r.stack[m] : r.localized[m];
      Json row = row_named(std::string("simt/") + kModelNames[m] + (is_stack ? "/stack" : "/localized"), s, r);
      row["rays"] = p.rays, row["simt_steps"] = issued(p), row["simt_efficiency"] = p.efficiency();
      row["simt_sectors"] = all_traffic(p).sectors;
      rows.push_back(row);
    }
}

}  // namespace

Result<Report> gl10(const Settings& settings) {
  const Result<std::vector<SceneResult>> measured = measure_all<SceneResult>(kScenes, measure, settings);
  if (!measured) return measured.error();
  const std::vector<SceneResult>& results = *measured;
  Report report;
  report.text = "Garanzha and Loop 2010, Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray Tracing\n\n" +
                table1(results) + figure13(results) + sort_table(results) + walk_table(results) + figures14_15(results) +
                simt_table(results) + notes(results, settings);
  for (std::size_t s = 0; s < results.size(); ++s) {
    add_grid_rows(s, results[s], report.rows);
    add_speed_rows(s, results[s], report.rows);
    add_other_rows(s, results[s], report.rows);
  }
  return report;
}

}  // namespace accel::paper_tables
