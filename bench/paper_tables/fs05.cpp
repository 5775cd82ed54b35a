// Foley and Sugerman 2005, "KD-Tree Acceleration Structures for a GPU Raytracer" [FS05]: Tables 1, 2 and 3.
//
// Times are ratios: a Radeon X800 of 2004 and a CPU have little else in common. The same rays are traced by the while-while
// executor, by the multipass executor, and, on paper, by the X800: our steps at the speed that Table 3 gives its kernels, with
// every lane at work. Trees are built with the paper's costs, 8 for a step and 1 for a triangle, and grids with its
// resolutions.
#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "bench/paper_tables/paper_tables.h"
#include "libaccel/build/kdtree_sah.h"
#include "libaccel/registry/any_accel.h"

namespace accel::paper_tables {

namespace {

using Kernel = MultipassKernel;

// The figures of the paper.
constexpr double kPaperRays = 512.0 * 512.0;

enum MethodIndex { kBrute, kGrid, kRestart, kBacktrack, kStack, kMethods };
constexpr const char* kMethodNames[kMethods] = {"brute/loop", "grid/dda", "kdtree/restart", "kdtree/backtrack", "kdtree/stack"};
constexpr const char* kTitles[kMethods] = {"Brute", "Grid", "Restart", "Backtrack", "(Stack)"};

struct SceneFigures {
  PaperScene scene;
  int grid;      // cells along each axis
  double ms[4];  // Table 1; the stack version was not implemented
};
constexpr SceneFigures kScenes[] = {{{"Cornell Box", "cornell-box", "builtin:cornell:36"}, 2, {23, 63, 80, 84}},
                                    {{"Bunny", "bunny", "builtin:terrain:69451"}, 50, {4620, 357, 701, 690}},
                                    {{"Robots", "bart-robots", "builtin:stadium:71708"}, 50, {4770, 8344, 968, 946}},
                                    {{"Kitchen", "bart-kitchen", "builtin:colonnade:110561"}, 50, {7350, 2687, 992, 857}}};

// Millions of rays in each state. The stack version's Down is Backtrack's, as section 4.1 says.
struct StateCounts {
  double down, up, tests, transitions;
};
struct Table2Figures {
  std::size_t scene;  // in kScenes
  StateCounts restart, backtrack;
};
constexpr Table2Figures kTable2[] = {{2, {31.68, 0, 6.84, 2.48}, {13.49, 9.80, 6.84, 2.48}},
                                     {3, {21.80, 0, 5.91, 2.13}, {10.86, 7.78, 5.91, 2.13}}};

struct KernelFigures {
  const char* title;
  MethodIndex method;
  Kernel kernel;
  double floats_in, floats_out, fetches, gigabytes_per_second;

  double ms(double rays) const { return rays * 4 * (floats_in + floats_out) / gigabytes_per_second * 1e-6; }
};
constexpr KernelFigures kTable3[] = {{"Brute Intersect", kBrute, Kernel::intersect, 12, 4, 0, 20.7},
                                     {"Grid Traverse", kGrid, Kernel::down, 26, 16, 2, 10.8},
                                     {"Grid Intersect", kGrid, Kernel::intersect, 36, 8, 16, 16.6},
                                     {"KD Down", kBacktrack, Kernel::down, 15, 4, 3, 15.7},
                                     {"KD Up", kBacktrack, Kernel::up, 20, 4, 8, 24.5},
                                     {"KD Intersect", kBacktrack, Kernel::intersect, 33, 8, 13, 18.5}};

// The kernels of Table 3 that a method runs: all kd-trees share theirs.
bool runs(MethodIndex method, const KernelFigures& kernel) {
  const MethodIndex owner = method == kRestart || method == kStack ? kBacktrack : method;
  return kernel.method == owner;
}

// Ours.
struct Measured {
  double while_ms = 0, multipass_ms = 0, model_ms = 0;  // of all rays of the picture
  MultipassProfile profile;                             // masked, of the rays that were traced
  double rays_each = 1;                                 // rays of the picture for each that was traced
  std::uint64_t bytes = 0;
  std::uint64_t other_hits = 0;  // of the rays that were traced: those whose hit is not the stack version's
};
struct SceneResult {
  bool is_stand_in = false;
  std::uint64_t triangles = 0;
  std::array<std::optional<Measured>, kMethods> methods;
};

// A method at work on its share of the rays: brute force gets every n-th, for it takes the same time for each.
struct Contender {
  MethodIndex index;
  AnyAccel accel;
  std::size_t first, stride;  // which rays of the picture
  std::vector<Ray> rays;
  double rays_each;
  std::vector<Hit> hits, multipass_hits;
  std::vector<double> while_ms, multipass_ms;
};

constexpr double kMostBruteTests = 4e7;

Result<AnyAccel> build(const TriangleMesh& mesh, MethodIndex index, int grid, const std::vector<Contender>& others) {
  for (const Contender& other : others)
    if (other.accel.method().builder == "kdtree" && index >= kRestart) return other.accel.with_method(kMethodNames[index]);
  BuildOptions options;
  if (index >= kRestart) {
    const KdCosts costs{.traversal = 8, .intersection = 1, .leaf = 0, .empty_bonus = options.empty_bonus};
    Result<Built<KdTree>> tree = KdTreeSah::build(mesh, options, costs);
    if (!tree) return tree.error();
    return AnyAccel::bind(AnyStructure(std::move(tree->structure)), kMethodNames[index], std::move(tree->report));
  }
  std::fill(std::begin(options.grid_resolution), std::end(options.grid_resolution), grid);
  return AnyAccel::build(mesh, kMethodNames[index], options);
}

Result<std::vector<Contender>> make_contenders(const TriangleMesh& mesh, const Buffer<Ray>& rays, int grid) {
  std::vector<Contender> contenders;
  for (int m = 0; m < kMethods; ++m) {
    const auto index = static_cast<MethodIndex>(m);
    Result<AnyAccel> accel = build(mesh, index, grid, contenders);
    if (!accel) return accel.error();
    std::size_t stride = 1;
    if (index == kBrute)
      stride =
          1 + static_cast<std::size_t>(static_cast<double>(mesh.size()) * static_cast<double>(rays.size()) / kMostBruteTests);
    const std::size_t first = std::min(stride / 2, rays.size() - 1);
    std::vector<Ray> share;
    for (std::size_t i = first; i < rays.size(); i += stride) share.push_back(rays[i]);
    const double rays_each = static_cast<double>(rays.size()) / static_cast<double>(share.size());
    std::vector<Hit> hits(share.size());
    contenders.push_back({index, *accel, first, stride, std::move(share), rays_each, hits, hits, {}, {}});
  }
  return contenders;
}

// One turn of each contender, in both executors; the first turn is not timed.
Status take_turns(std::vector<Contender>& contenders, const Settings& settings) {
  const TraceOptions options{.threads = settings.threads};
  const MultipassOptions compact{.compact = true};
  for (int turn = 0; turn <= settings.repeat; ++turn) {
    for (Contender& c : contenders) {
      const auto in_one = [&] { return c.accel.closest(c.rays, c.hits, options); };
      const auto in_passes = [&]() -> Status {
        const auto profile = c.accel.trace_multipass(c.rays, Query::closest, c.multipass_hits, compact, options);
        return profile ? Status(Done{}) : Status(profile.error());
      };
      if (const Status s = time_ms(in_one, c.while_ms); !s) return s;
      if (const Status s = time_ms(in_passes, c.multipass_ms); !s) return s;
      if (turn == 0) c.while_ms.clear(), c.multipass_ms.clear();
      if (!same_bits(c.hits, c.multipass_hits))
        return Error{c.accel.method().name + ": the executors' hits differ, which is a bug"};
    }
  }
  return Done{};
}

// The stack version traces all rays. The kd-tree's traversers test the same triangles in the same order (section 2.2), so their
// hits are the same; those of other structures may differ where core/hit.h says.
Result<std::uint64_t> other_hits(const Contender& c, const Contender& stack) {
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < c.hits.size(); ++i)
    count += std::memcmp(&c.hits[i], &stack.hits[c.first + i * c.stride], sizeof(Hit)) != 0 ? 1 : 0;
  if (count > 0 && c.accel.method().builder == "kdtree")
    return Error{c.accel.method().name + ": its hits are not the stack version's, which is a bug"};
  return count;
}

double steps(const Measured& m, Kernel kernel) { return static_cast<double>(m.profile.of(kernel).rays) * m.rays_each; }

Result<SceneResult> measure(const SceneFigures& figures, const Settings& settings) {
  const Result<LoadedScene> scene = load(figures.scene, settings);
  if (!scene) return scene.error();
  const TriangleMesh& mesh = scene->data.mesh;
  const auto rays = primary_rays(scene->data, settings.size);
  if (!rays) return rays.error();
  auto contenders = make_contenders(mesh, rays->rays, figures.grid);
  if (!contenders) return contenders.error();
  if (const Status s = take_turns(*contenders, settings); !s) return s.error();

  SceneResult result{.is_stand_in = scene->is_stand_in, .triangles = mesh.size()};
  for (const Contender& c : *contenders) {
    const auto profile = c.accel.trace_multipass(c.rays, Query::closest, {}, {}, {.threads = settings.threads});
    if (!profile) return profile.error();
    const Result<std::uint64_t> others = other_hits(c, contenders->back());
    if (!others) return others.error();
    Measured m{.profile = *profile, .rays_each = c.rays_each, .bytes = c.accel.size_bytes(), .other_hits = *others};
    m.while_ms = median(c.while_ms) * c.rays_each, m.multipass_ms = median(c.multipass_ms) * c.rays_each;
    for (const KernelFigures& kernel : kTable3)
      if (runs(c.index, kernel)) m.model_ms += kernel.ms(steps(m, kernel.kernel));
    result.methods[c.index] = m;
  }
  return result;
}

std::string millions(double value) { return print("%.2f M", value * 1e-6); }

std::string table1(const std::vector<SceneResult>& results, const Settings& settings) {
  std::string text = print("Table 1: primary rays, %u x %u. Times as multiples of Restart's in the same column\n",
                           settings.size, settings.size);
  TextTable table({"scene, method", "paper ms", "x", "while-while ms", "x", "multipass ms", "x", "X800 model ms", "x"});
  for (std::size_t s = 0; s < results.size(); ++s) {
    table.add({title_of(kScenes[s].scene, results[s].is_stand_in)});
    const Measured& unit = *results[s].methods[kRestart];
    for (int m = 0; m < kMethods; ++m) {
      const Measured& ours = *results[s].methods[m];
      const bool in_paper = m < kStack;
      const double paper = in_paper ? kScenes[s].ms[m] : 0;
      table.add({std::string("  ") + kTitles[m], in_paper ? print("%.0f", paper) : "",
                 in_paper ? number(paper / kScenes[s].ms[kRestart]) : "", number(ours.while_ms),
                 number(ours.while_ms / unit.while_ms), number(ours.multipass_ms),
                 number(ours.multipass_ms / unit.multipass_ms), number(ours.model_ms), number(ours.model_ms / unit.model_ms)});
    }
  }
  return text + table.text();
}

// Scaled to the paper's number of rays.
StateCounts counts_of(const Measured& m) {
  const double scale = kPaperRays / (static_cast<double>(m.profile.rays) * m.rays_each);
  return {steps(m, Kernel::down) * scale, steps(m, Kernel::up) * scale, steps(m, Kernel::intersect) * scale,
          static_cast<double>(m.profile.transitions()) * m.rays_each * scale};
}
StateCounts operator*(const StateCounts& c, double scale) {
  return {c.down * scale, c.up * scale, c.tests * scale, c.transitions * scale};
}

std::string table2(const std::vector<SceneResult>& results) {
  std::string text = "\nTable 2: how often 512 x 512 rays were in each state; ratio: (Down + Up) / the stack version's Down\n";
  TextTable table({"scene, method", "Down", "paper", "Up", "paper", "Tests", "paper", "Trans.", "paper", "ratio", "paper"});
  for (const Table2Figures& figures : kTable2) {
    const SceneResult& result = results[figures.scene];
    table.add({title_of(kScenes[figures.scene].scene, result.is_stand_in)});
    const double stack_down = counts_of(*result.methods[kStack]).down, paper_down = figures.backtrack.down * 1e6;
    for (const MethodIndex m : {kStack, kRestart, kBacktrack}) {
      const StateCounts ours = counts_of(*result.methods[m]);
      const StateCounts paper = (m == kRestart ? figures.restart : figures.backtrack) * 1e6;
      const bool in_paper = m != kStack;
      const auto theirs = [&](double value) { return in_paper ? millions(value) : std::string(); };
      table.add({std::string("  ") + kTitles[m], millions(ours.down), in_paper ? millions(paper.down) : millions(paper_down),
                 m == kStack ? "" : millions(ours.up), theirs(paper.up), millions(ours.tests), theirs(paper.tests),
                 millions(ours.transitions), theirs(paper.transitions),
                 m == kStack ? "1.00" : number((ours.down + ours.up) / stack_down),
                 in_paper ? number((paper.down + paper.up) / paper_down) : ""});
    }
  }
  return text + table.text();
}

// What a ray's step moves, in floats: what it carries and what it fetches on one side, what it leaves behind on the other.
std::string table3(const std::vector<SceneResult>& results) {
  std::string text = "\nTable 3 (Kitchen): floats in and out for a ray, and of those in, fetched from the structure\n";
  TextTable table({"kernel", "in", "paper", "out", "paper", "fetched", "paper"});
  for (const KernelFigures& paper : kTable3) {
    const auto& p = results.back().methods[paper.method]->profile.of(paper.kernel);
    const double rays = 4 * std::max(1.0, static_cast<double>(p.rays));
    const double fetched = static_cast<double>(p.bytes_fetched) / rays, read = static_cast<double>(p.bytes_read) / rays;
    table.add({paper.title, print("%.1f", read + fetched), print("%.0f", paper.floats_in),
               print("%.1f", static_cast<double>(p.bytes_written) / rays), print("%.0f", paper.floats_out),
               print("%.1f", fetched), print("%.0f", paper.fetches)});
  }
  return text + table.text();
}

std::string streams(const std::vector<SceneResult>& results) {
  const std::string text = heading(
      "The streams: passes by Delany's rule; rays at work, of all lanes that a masked pass runs over and of those in warps of "
      "32 "
      "that cannot be skipped; bytes per ray that are carried from pass to pass, and fetched from the structure");
  TextTable table({"scene, method", "passes", "switches", "rays/pass", "of all", "of warps", "carried", "fetched"});
  for (std::size_t s = 0; s < results.size(); ++s) {
    table.add({kScenes[s].scene.title});
    for (int m = 0; m < kMethods; ++m) {
      const MultipassProfile& p = results[s].methods[m]->profile;
      const MultipassProfile::KernelPasses all = p.total();
      const double rays = static_cast<double>(p.rays);
      table.add({std::string("  ") + kTitles[m], print("%llu", static_cast<unsigned long long>(all.passes)),
                 print("%llu", static_cast<unsigned long long>(p.switches)), print("%.0f", all.rays_per_pass()),
                 percent(all.utilisation()), percent(all.warp_utilisation()),
                 print("%.0f", static_cast<double>(all.bytes_recirculated()) / rays),
                 print("%.0f", static_cast<double>(all.bytes_fetched) / rays)});
    }
  }
  return text + table.text();
}

// The X800's time for the paper's own counts, every lane at work.
double model_ms(const StateCounts& counts) {
  double ms = 0;
  for (const KernelFigures& kernel : kTable3) {
    if (kernel.method != kBacktrack) continue;
    ms += kernel.ms(1e6 * (kernel.kernel == Kernel::down ? counts.down
                           : kernel.kernel == Kernel::up ? counts.up
                                                         : counts.tests));
  }
  return ms;
}

std::string ratios(const std::vector<SceneResult>& results, MethodIndex method) {
  std::string text;
  for (const Table2Figures& figures : kTable2) {
    const StateCounts ours = counts_of(*results[figures.scene].methods[method]);
    const StateCounts& paper = method == kRestart ? figures.restart : figures.backtrack;
    text += print("%s%.2f on %s (paper %.2f)", text.empty() ? "" : ", ",
                  (ours.down + ours.up) / counts_of(*results[figures.scene].methods[kStack]).down,
                  kScenes[figures.scene].scene.title, (paper.down + paper.up) / figures.backtrack.down);
  }
  return text;
}

// How much of Table 2 the views explain, and how much the trees.
std::string counts_note(const Table2Figures& figures, const SceneResult& result) {
  const StateCounts ours = counts_of(*result.methods[kStack]), paper = figures.backtrack * 1e6;
  return paragraph(
      print("%s: %.2f x the paper's leaves and %.2f x its tests, and %.1f steps down to a leaf where the paper has %.1f.",
            kScenes[figures.scene].scene.title, ours.transitions / paper.transitions, ours.tests / paper.tests,
            2 * ours.down / ours.transitions, 2 * paper.down / paper.transitions));
}

constexpr char kBruteNote[] = R"(Brute force is measured on every n-th ray and scaled. The paper's own times for it disagree:
  66 us a triangle in the three large scenes, 3.9 G tests/s, but 719 us in the Cornell Box, 0.36 G tests/s, and section 3 says
  0.35 G tests/s. At that rate the large scenes would take 52 to 83 s, as the model has it, not 5 to 7 s.)";
constexpr char kRateNote[] = R"(The X800's kernels at full speed need %.0f ms for the paper's counts of Robots with Restart and
  %.0f ms with Backtrack; it measured 968 and 946. The rest, a factor of %.1f and %.1f, is masking and switching (section 5:
  "more than five").)";
constexpr char kMaskNote[] = R"(In our masked passes (Robots, Restart) %.0f %% of all lanes are at work, and %.0f %% of those in
  warps with any at work: a machine that skips idle warps, as early z-culling does in part, loses a factor between %.1f and
  %.1f.)";

// What Table 1 and the streams say about the X800.
std::string machine_notes(const std::vector<SceneResult>& results) {
  const double restart = model_ms(kTable2[0].restart), backtrack = model_ms(kTable2[0].backtrack);
  const MultipassProfile::KernelPasses passes = results[2].methods[kRestart]->profile.total();
  return paragraph(kBruteNote) + paragraph(print(kRateNote, restart, backtrack, 968 / restart, 946 / backtrack)) +
         paragraph(print(kMaskNote, 100 * passes.utilisation(), 100 * passes.warp_utilisation(), 1 / passes.warp_utilisation(),
                         1 / passes.utilisation()));
}

std::string notes(const std::vector<SceneResult>& results) {
  std::string text = notes_title(results);
  text += paragraph("Steps as multiples of the stack version's: Restart " + ratios(results, kRestart) + "; Backtrack " +
                    ratios(results, kBacktrack) + ".");
  for (const Table2Figures& figures : kTable2) text += counts_note(figures, results[figures.scene]);
  text += paragraph(
      "Leaves and tests tell how near the view is, steps to a leaf how the trees differ: ours split clipped triangles and cut "
      "off empty space, from the same costs.");
  const auto grid = [&](std::size_t s) { return results[s].methods[kGrid]->while_ms / results[s].methods[kRestart]->while_ms; };
  text += paragraph(
      print("Grid against Restart, while-while: %.2f on Bunny (paper 0.51), %.2f on Robots (paper 8.62).", grid(1), grid(2)));
  std::uint64_t others = 0, rays = 0;
  for (const SceneResult& result : results)
    for (const auto& m : result.methods) others += m->other_hits, rays += m->profile.rays;
  text += paragraph(print("Hits that are not the stack version's: %llu of %llu.", static_cast<unsigned long long>(others),
                          static_cast<unsigned long long>(rays)));
  return text + machine_notes(results);
}

Json row_json(std::size_t scene, int m, const SceneResult& result, const Settings& settings) {
  const Measured& ours = *result.methods[m];
  const MultipassProfile::KernelPasses all = ours.profile.total();
  const StateCounts counts = counts_of(ours);
  Json row = new_row("fs05", kScenes[scene].scene, result.is_stand_in, kMethodNames[m]);
  row.update({{"iterations", settings.repeat},
              {"real_time", ours.while_ms},
              {"cpu_time", ours.while_ms},
              {"time_unit", "ms"},
              {"method", kMethodNames[m]},
              {"multipass_ms", ours.multipass_ms},
              {"model_ms", ours.model_ms},
              {"rays_measured", ours.profile.rays},
              {"down", counts.down},
              {"up", counts.up},
              {"tests", counts.tests},
              {"transitions", counts.transitions},
              {"passes", all.passes},
              {"switches", ours.profile.switches},
              {"utilisation", all.utilisation()},
              {"warp_utilisation", all.warp_utilisation()},
              {"bytes_recirculated", all.bytes_recirculated()},
              {"bytes_fetched", all.bytes_fetched},
              {"bytes", ours.bytes},
              {"other_hits", ours.other_hits}});
  if (m < kStack) row["paper_ms"] = kScenes[scene].ms[m];
  return row;
}

}  // namespace

Result<Report> fs05(const Settings& settings) {
  const Result<std::vector<SceneResult>> measured = measure_all<SceneResult>(kScenes, measure, settings);
  if (!measured) return measured.error();
  const std::vector<SceneResult>& results = *measured;
  Report report;
  report.text = "Foley and Sugerman 2005, KD-Tree Acceleration Structures for a GPU Raytracer\n\n" + table1(results, settings) +
                table2(results) + table3(results) + streams(results) + notes(results);
  for (std::size_t s = 0; s < results.size(); ++s)
    for (int m = 0; m < kMethods; ++m) report.rows.push_back(row_json(s, m, results[s], settings));
  return report;
}

}  // namespace accel::paper_tables
