// Binder and Keller 2016, "Efficient Stackless Hierarchy Traversal on GPUs with Backtracking in Constant Time" [BK16]: Tables 1
// and 2, and the histogram of Figure 3.
//
// Speeds are ratios to the stack version on the same rays and machine, here a CPU; what a GPU would make of the same state
// machines is told by the SIMT model (exec/simt.h): issued steps and memory traffic in warps of 32.
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <optional>

#include "bench/paper_tables/paper_tables.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/exec/drive.h"
#include "libaccel/exec/simt.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/trace/bvh2_hash.h"
#include "libaccel/trace/bvh2_sibling.h"

namespace accel::paper_tables {

namespace {

enum KindIndex { kPrimary, kShadow, kDiffuse, kKinds };
constexpr const char* kKindTitles[kKinds] = {"Primary", "Shadow", "Diffuse"};  // shadow: of the diffuse rays, whether they hit
constexpr Query kQueries[kKinds] = {Query::closest, Query::any, Query::closest};

// The stack version comes first: all others are compared with it. hash-1 is no method of its own: the paper's variant, with one
// register, which sbvh/hash is on devices.
constexpr const char* kMethods[] = {"sbvh/stack",  "sbvh/hash",          "sbvh/hash-1", "sbvh/uncle",      "sbvh/sibling",
                                    "sbvh/parent", "sbvh/restart-trail", "sbvh/skip",   "sbvh/skip-octant"};
constexpr std::size_t kMethodCount = std::size(kMethods);
constexpr std::size_t kStack = 0, kHash = 1, kHashOne = 2, kSibling = 4;

// The paper's figures, where it has the scene: thousands of triangles, megabytes and milliseconds of the hash tables, what they
// add in percent, and the speed of the sibling version as percent of the stack version's.
struct PaperFigures {
  double triangles, megabytes, percent, ms;
  double sibling[kKinds];
};
struct SceneFigures {
  PaperScene scene;
  std::optional<PaperFigures> paper;
};
const SceneFigures kScenes[] = {
    {{"Sponza", "sponza", "builtin:colonnade:66454"}, PaperFigures{262, 1.8, 6, 0.40, {80, 84, 76}}},
    {{"Conference", "conference", "builtin:stadium:100000"}, PaperFigures{282, 1.9, 6, 0.49, {84, 98, 87}}},
    {{"Dragon", "dragon", "builtin:spheres:90000"}, PaperFigures{871, 5.7, 7, 0.65, {84, 87, 85}}},
    {{"Bunny", "bunny", "builtin:terrain:69451"}, {}},
    {{"BART Kitchen", "bart-kitchen", "builtin:soup:50000"}, {}},
    {{"Bathroom", "bathroom", "builtin:slivers:20000"}, {}},
    {{"Country Kitchen", "country-kitchen", "builtin:hairball:90000"}, {}}};

// The averages over the paper's 21 scenes, as percent of the stack version's speed: siblings, and the hash.
constexpr double kPaperSibling[kKinds] = {83, 88, 81}, kPaperHash[kKinds] = {108, 120, 117};

// How far backtracking goes, in levels between the node that it leaves and the sibling of the node that it goes to: 0 for the
// sibling, 1 for the uncle, 2 for the grand-uncle.
constexpr std::size_t kDistances = 32;  // the last one counts what is farther, too
using Histogram = std::array<double, kDistances>;

// Ours.
struct MethodResult {
  double mrays[kKinds] = {};
  SimtProfile simt[kKinds];
};
struct SceneResult {
  bool is_stand_in = false;
  std::uint64_t triangles = 0;
  std::size_t bytes = 0, hash_bytes = 0;  // of nodes and triangles, and of the tables
  double build_ms = 0, hash_ms = 0;
  std::array<MethodResult, kMethodCount> methods;
  Histogram distances{};
};

// The rays of a kind, and what all methods say about them.
struct RayBatch {
  Buffer<Ray> rays;
  std::vector<Hit> hits;
  std::vector<std::uint8_t> occluded;
};
using Batches = std::array<RayBatch, kKinds>;

Status trace(const AnyAccel& accel, int kind, RayBatch& batch, const TraceOptions& options) {
  return kQueries[kind] == Query::any ? accel.occluded(batch.rays, batch.occluded, options)
                                      : accel.closest(batch.rays, batch.hits, options);
}

// run(view, std::type_identity<T>{}) with the traverser of sbvh/hash that devices choose.
template <Query kQuery, class Run>
auto with_one_register(const AnyAccel& hash, const Run& run) {
  const Bvh2View view = hash.structure().get_if<Bvh2>()->view();
  return with_traverser<Bvh2Hash<Watertight, kQuery>, Machine::device>(view, [&](auto type) { return run(view, type); });
}

Status trace_with_one_register(const AnyAccel& hash, int kind, RayBatch& batch, const TraceOptions& options) {
  if (kQueries[kind] == Query::any)
    with_one_register<Query::any>(hash, [&]<class T>(const Bvh2View& view, std::type_identity<T>) {
      trace_any<T>(view, batch.rays.span(), batch.occluded, options.threads);
    });
  else
    with_one_register<Query::closest>(hash, [&]<class T>(const Bvh2View& view, std::type_identity<T>) {
      trace_closest<T>(view, batch.rays.span(), batch.hits, options.threads);
    });
  return Done{};
}

SimtProfile profile_with_one_register(const AnyAccel& hash, int kind, const RayBatch& batch, int threads) {
  const auto profile = [&]<class T>(const Bvh2View& view, std::type_identity<T>) {
    return simulate_simt<T>(view, batch.rays.span(), {}, {}, threads);
  };
  return kQueries[kind] == Query::any ? with_one_register<Query::any>(hash, profile)
                                      : with_one_register<Query::closest>(hash, profile);
}

Result<Batches> make_batches(const SceneData& scene, const AnyAccel& accel, const Settings& settings) {
  auto primary = primary_rays(scene, settings.size, PixelOrder::z_curve);
  if (!primary) return primary.error();
  std::vector<Hit> hits(primary->size());
  if (const Status s = accel.closest(primary->rays, hits); !s) return s.error();
  const PrimaryHits from{scene.mesh, *primary, hits};
  auto diffuse = diffuse_rays(from);
  if (!diffuse) return diffuse.error();

  Batches batches;
  batches[kShadow].rays = diffuse->rays;
  batches[kDiffuse].rays = std::move(diffuse->rays);
  batches[kPrimary].rays = std::move(primary->rays);
  for (RayBatch& batch : batches) batch.hits.resize(batch.rays.size()), batch.occluded.resize(batch.rays.size());
  return batches;
}

// All methods in turns, one kind of rays after the other; the first turn is not timed. All must give the same answers.
Status take_turns(const std::vector<AnyAccel>& accels, Batches& batches, const Settings& settings, SceneResult& result) {
  const TraceOptions options{.threads = settings.threads};
  for (int kind = 0; kind < kKinds; ++kind) {
    RayBatch& batch = batches[kind];
    std::vector<std::vector<double>> times(accels.size());
    if (const Status s = trace(accels[kStack], kind, batch, options); !s) return s;
    const RayBatch expected{{}, batch.hits, batch.occluded};
    for (int turn = 0; turn <= settings.repeat; ++turn) {
      for (std::size_t m = 0; m < accels.size(); ++m) {
        const auto run = m == kHashOne ? trace_with_one_register : trace;
        if (const Status s = time_ms([&] { return run(accels[m], kind, batch, options); }, times[m]); !s) return s;
        if (turn == 0) times[m].clear();
        if (!same_bits(batch.hits, expected.hits) || batch.occluded != expected.occluded)
          return Error{std::string(kMethods[m]) + ": its hits are not the stack version's, which is a bug"};
      }
    }
    for (std::size_t m = 0; m < accels.size(); ++m)
      result.methods[m].mrays[kind] = mrays_of(batch.rays.size(), median(times[m]));
  }
  return Done{};
}

// Counts how far backtracking goes, by a traverser that climbs level by level.
struct ClimbObserver : NullObserver {
  Histogram& distances;
  std::size_t climbed = 0;

  explicit ClimbObserver(Histogram& histogram) : distances(histogram) {}
  void backtrack() { ++climbed; }
  void node_step() { arrive(); }
  void leaf_visit(std::uint32_t) { arrive(); }

 private:
  void arrive() {
    if (climbed > 0) ++distances[std::min(climbed, kDistances) - 1];
    climbed = 0;
  }
};

void count_distances(const AnyAccel& sibling, const Batches& batches, Histogram& distances) {
  const Bvh2View view = sibling.structure().get_if<Bvh2>()->view();
  ClimbObserver observer(distances);
  for (int kind = 0; kind < kKinds; ++kind)
    for (const Ray& ray : batches[kind].rays) {
      observer.climbed = 0;
      if (kQueries[kind] == Query::any)
        trace_ray<Bvh2Sibling<Watertight, Query::any>>(view, ray, observer);
      else
        trace_ray<Bvh2Sibling<Watertight, Query::closest>>(view, ray, observer);
    }
}

// What binding the hash version adds to the tree: bytes and the time of the phase, as a median.
Status measure_tables(const AnyAccel& stack, const Settings& settings, SceneResult& result) {
  std::vector<double> times;
  // Binding takes all threads, and building as many as it is told.
  std::optional<tbb::global_control> limit;
  if (settings.threads > 0)
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(settings.threads));
  for (int turn = 0; turn < settings.repeat; ++turn) {
    const auto hash = stack.with_method(kMethods[kHash]);
    if (!hash) return hash.error();
    result.hash_bytes = hash->size_bytes() - stack.size_bytes();
    for (const BuildPhase& phase : hash->report().phases)
      if (phase.name == Bvh2::extras_name(Bvh2Extras::hash)) times.push_back(1e3 * phase.seconds);
  }
  result.hash_ms = median(times);
  return Done{};
}

Result<SceneResult> measure(const SceneFigures& figures, const Settings& settings) {
  const auto scene = load(figures.scene, settings);
  if (!scene) return scene.error();
  const auto stack = AnyAccel::build(scene->data.mesh, kMethods[kStack],
                                     {.threads = settings.threads, .spatial_overlap = 1e-5f, .reinsertion_rounds = 0});
  if (!stack) return stack.error();
  std::vector<AnyAccel> accels;
  for (std::size_t m = 0; m < kMethodCount; ++m) {
    auto accel = stack->with_method(kMethods[m == kHashOne ? kHash : m]);
    if (!accel) return accel.error();
    accels.push_back(*std::move(accel));
  }

  SceneResult result{.is_stand_in = scene->is_stand_in,
                     .triangles = scene->data.mesh.size(),
                     .bytes = stack->size_bytes(),
                     .build_ms = 1e3 * stack->report().seconds};
  if (const Status s = measure_tables(*stack, settings, result); !s) return s.error();
  auto batches = make_batches(scene->data, *stack, settings);
  if (!batches) return batches.error();
  if (const Status s = take_turns(accels, *batches, settings, result); !s) return s.error();
  for (std::size_t m = 0; m < kMethodCount; ++m)
    for (int kind = 0; kind < kKinds; ++kind) {
      if (m == kHashOne) {
        result.methods[m].simt[kind] = profile_with_one_register(accels[m], kind, (*batches)[kind], settings.threads);
        continue;
      }
      const auto profile = accels[m].profile_simt((*batches)[kind].rays, kQueries[kind], {}, {}, {.threads = settings.threads});
      if (!profile) return profile.error();
      result.methods[m].simt[kind] = *profile;
    }
  count_distances(accels[kSibling], *batches, result.distances);
  return result;
}

std::string title_of(const SceneResult& result, std::size_t s) { return title_of(kScenes[s].scene, result.is_stand_in); }

// A figure of the paper, or nothing where it does not have the scene.
std::string theirs(const std::optional<PaperFigures>& paper, double PaperFigures::*value, const char* unit = "") {
  return paper ? print("%g%s", (*paper).*value, unit) : std::string();
}

std::string table1(const std::vector<SceneResult>& results) {
  std::string text = "Table 1: the hash tables, and what they add to nodes and triangles\n";
  TextTable table({"scene", "k triangles", "paper", "MB", "paper", "increase", "paper", "ms", "paper's GPU", "of the build"});
  for (std::size_t s = 0; s < results.size(); ++s) {
    const SceneResult& r = results[s];
    const auto& paper = kScenes[s].paper;
    table.add({title_of(r, s), print("%.0f", 1e-3 * static_cast<double>(r.triangles)), theirs(paper, &PaperFigures::triangles),
               number(1e-6 * static_cast<double>(r.hash_bytes)), theirs(paper, &PaperFigures::megabytes),
               percent(static_cast<double>(r.hash_bytes) / static_cast<double>(r.bytes)),
               theirs(paper, &PaperFigures::percent, " %"), number(r.hash_ms), theirs(paper, &PaperFigures::ms),
               percent(r.hash_ms / r.build_ms)});
  }
  return text + table.text();
}

std::string figure3(const std::vector<SceneResult>& results) {
  Histogram shares{};
  for (const SceneResult& r : results) {
    const double all = std::max(1.0, std::accumulate(r.distances.begin(), r.distances.end(), 0.0));
    for (std::size_t d = 0; d < kDistances; ++d) shares[d] += r.distances[d] / all / static_cast<double>(results.size());
  }
  std::string text = "\nFigure 3: how far backtracking goes, in levels, averaged over scenes; 0 is the sibling\n";
  TextTable table({"levels", "share", "so far", ""});
  double sum = 0;
  for (std::size_t d = 0; d < kDistances && sum < 0.999; ++d) {
    sum += shares[d];
    const std::string bar(static_cast<std::size_t>(std::lround(60 * shares[d])), '#');
    table.add({d == 0   ? "0 sibling"
               : d == 1 ? "1 uncle"
               : d == 2 ? "2 grand-uncle"
                        : print("%zu", d),
               percent(shares[d]), percent(sum), bar});
  }
  return text + table.text();
}

double speed(const SceneResult& r, std::size_t method, int kind) {
  return r.methods[method].mrays[kind] / std::max(r.methods[kStack].mrays[kind], 1e-9);
}

double mean_speed(const std::vector<SceneResult>& results, std::size_t method, int kind) {
  double sum = 0;
  for (const SceneResult& r : results) sum += speed(r, method, kind);
  return sum / static_cast<double>(results.size());
}

// The fastest of the stackless methods.
std::size_t best_stackless(const SceneResult& r, int kind) {
  std::size_t best = kHash;
  for (std::size_t m = kHash; m < kMethodCount; ++m)
    if (r.methods[m].mrays[kind] > r.methods[best].mrays[kind]) best = m;
  return best;
}

std::string traverser_of(std::size_t method) { return std::strchr(kMethods[method], '/') + 1; }

std::string table2(const std::vector<SceneResult>& results, const Settings& settings) {
  std::string text;
  for (int kind = 0; kind < kKinds; ++kind) {
    text += print("\n%s, %u x %u: speed as percent of the stack version's\n", kKindTitles[kind], settings.size, settings.size);
    std::vector<std::string> titles = {"scene", "stack Mrays/s"};
    for (std::size_t m = kHash; m < kMethodCount; ++m) titles.push_back(traverser_of(m));
    titles.insert(titles.end(), {"best", "paper: sibling", "hash"});
    TextTable table(titles);
    for (std::size_t s = 0; s < results.size(); ++s) {
      std::vector<std::string> row = {title_of(results[s], s), number(results[s].methods[kStack].mrays[kind])};
      for (std::size_t m = kHash; m < kMethodCount; ++m) row.push_back(print("%.0f", 100 * speed(results[s], m, kind)));
      row.push_back(traverser_of(best_stackless(results[s], kind)));
      row.push_back(kScenes[s].paper ? print("%g", kScenes[s].paper->sibling[kind]) : "");
      table.add(row);
    }
    std::vector<std::string> row = {"average", ""};
    for (std::size_t m = kHash; m < kMethodCount; ++m) row.push_back(print("%.0f", 100 * mean_speed(results, m, kind)));
    row.insert(row.end(), {"", print("%g", kPaperSibling[kind]), print("%g", kPaperHash[kind])});
    table.add(row);
    text += table.text();
  }
  return "\nTable 2" + text;
}

// What the model of a GPU counts, summed over the scenes, which have about as many rays each.
SimtProfile total(const std::vector<SceneResult>& results, std::size_t method, int kind) {
  SimtProfile sum;
  for (const SceneResult& r : results) sum += r.methods[method].simt[kind];
  return sum;
}

std::string simt_table(const std::vector<SceneResult>& results) {
  const std::string text = heading(
      "The SIMT model's prediction for a GPU: while-while, warps of 32; steps that a warp issues, lanes at work in them, "
      "transactions (distinct sectors of 32 bytes), and bytes by class, for a ray, averaged over scenes");
  TextTable table(
      {"rays, method", "steps", "x stack", "lanes", "sectors", "x stack", "node B", "triangle B", "stack B", "hash B"});
  for (int kind = 0; kind < kKinds; ++kind) {
    table.add({kKindTitles[kind]});
    const SimtProfile stack = total(results, kStack, kind);
    for (std::size_t m = 0; m < kMethodCount; ++m) {
      const SimtProfile p = total(results, m, kind);
      const double rays = std::max(1.0, static_cast<double>(p.rays)), sectors = static_cast<double>(all_traffic(p).sectors);
      table.add({"  " + traverser_of(m), number(static_cast<double>(issued(p)) / rays * kWarpSize),
                 number(static_cast<double>(issued(p)) / static_cast<double>(issued(stack))), percent(p.efficiency()),
                 number(sectors / rays), number(sectors / static_cast<double>(all_traffic(stack).sectors)),
                 print("%.0f", p.bytes_per_ray(Memory::node)), print("%.0f", p.bytes_per_ray(Memory::triangle)),
                 print("%.0f", p.bytes_per_ray(Memory::stack)), print("%.1f", p.bytes_per_ray(Memory::hash))});
    }
  }
  return text + table.text();
}

constexpr char kSceneNote[] =
    "Sponza here is Dabrovic's with 66,454 triangles, the paper's Crytek's; Conference has 331,179 triangles here.";
constexpr char kHashNote[] = R"(Tables are sized by the keys that can be looked up, the paper's by all nodes. Times to make
  them are those of a CPU here, of a GeForce GTX Titan X there.)";
constexpr char kRegisterNote[] = R"(hash on CPUs remembers the four most recently postponed nodes and where the ray enters
  them, and rarely reads its tables; hash-1 is the paper's variant with one register, which hash is on devices, and so in the
  model.)";
constexpr char kStackNote[] = R"(On a CPU the stack lies in the nearest cache and costs next to nothing, and it remembers
  where the ray enters a postponed node, so that the node is dropped unread when a nearer hit was found; stackless versions
  read it and test its children's boxes. The paper's stack version does not drop nodes either, and pays for its stack with
  memory traffic. The steps above tell the first effect, the bytes of stack and hash the second.)";

std::string notes(const std::vector<SceneResult>& results) {
  return notes_title(results) + paragraph(kSceneNote) + paragraph(kHashNote) + paragraph(kRegisterNote) + paragraph(kStackNote);
}

Json row_json(std::size_t s, std::size_t m, int kind, const SceneResult& r, const Settings& settings) {
  const SimtProfile& p = r.methods[m].simt[kind];
  Json row = new_row("bk16", kScenes[s].scene, r.is_stand_in, std::string(kKindTitles[kind]) + "/" + kMethods[m]);
  row.update({{"iterations", settings.repeat},
              {"method", kMethods[m]},
              {"rays", p.rays},
              {"mrays_per_second", r.methods[m].mrays[kind]},
              {"ratio_to_stack", speed(r, m, kind)},
              {"simt_steps", issued(p)},
              {"simt_efficiency", p.efficiency()},
              {"simt_sectors", all_traffic(p).sectors}});
  if (m == kHash)
    row["hash_bytes"] = r.hash_bytes, row["hash_ms"] = r.hash_ms, row["build_ms"] = r.build_ms, row["bytes"] = r.bytes;
  return row;
}

}  // namespace

Result<Report> bk16(const Settings& settings) {
  const Result<std::vector<SceneResult>> measured = measure_all<SceneResult>(kScenes, measure, settings);
  if (!measured) return measured.error();
  const std::vector<SceneResult>& results = *measured;
  Report report;
  report.text =
      "Binder and Keller 2016, Efficient Stackless Hierarchy Traversal on GPUs with Backtracking in Constant Time\n\n" +
      table1(results) + figure3(results) + table2(results, settings) + simt_table(results) + notes(results);
  for (std::size_t s = 0; s < results.size(); ++s)
    for (int kind = 0; kind < kKinds; ++kind)
      for (std::size_t m = 0; m < kMethodCount; ++m) report.rows.push_back(row_json(s, m, kind, results[s], settings));
  return report;
}

}  // namespace accel::paper_tables
