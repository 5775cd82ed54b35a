// Garanzha and Loop 2010, "Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray Tracing" [GL10]: Table 1, Figures 12
// to 15, and what the text of section 5 compares: compression-sorting-decompression with a plain sort, breadth-first with
// depth-first traversal, the Octo-BVH with the binary tree. What is measured, and how: gl10.h.
#include "bench/paper_tables/gl10.h"

namespace accel::paper_tables {

namespace garanzha_loop {

namespace {

// Table 1, of this many million rays at most.
constexpr double kPaperMrays = 1024e-6 * 768 * kSoftShadowSamples;
constexpr PaperTable kConference = {{{859, 119, 30}, {691, 91, 30.9}, {618, 78, 31.7}, {640, 74, 31.9}},
                                    {{945, 116, 29}, {572, 62, 30.8}, {438, 44, 31.6}, {447, 39, 31.9}},
                                    {{792, 96, 29.5}, {431, 44, 31.0}, {303, 26, 31.6}, {294, 21, 31.9}}};
constexpr PaperTable kSponza = {{{721, 77, 30.8}, {610, 66, 31.4}, {557, 60, 31.8}, {546, 59, 31.9}},
                                {{512, 50, 30.9}, {378, 37, 31.5}, {318, 32, 31.8}, {303, 30, 31.9}},
                                {{494, 45, 30.8}, {283, 25, 31.5}, {189, 14, 31.8}, {171, 16, 31.9}}};

// The ratios that the text gives.
constexpr double kPaperSpeed = 3, kPaperCsd = 2, kPaperDepthFirst = 5, kPaperBinary = 2;

// The paper's scenes, and two rooms for its Fairy Forest, one of which stands for it in Figure 15, too.
constexpr SceneFigures kScenes[] = {{{"BART Kitchen", "bart-kitchen", "builtin:soup:20000"}, nullptr, false},
                                    {{"Bathroom", "bathroom", "builtin:slivers:20000"}, nullptr, true},
                                    {{"Conference", "conference", "builtin:stadium:100000"}, &kConference, false},
                                    {{"Sponza", "sponza", "builtin:colonnade:66454"}, &kSponza, false}};

double per(double value, double of) { return value / std::max(of, 1e-9); }
double per(std::size_t value, std::size_t of) { return per(static_cast<double>(value), static_cast<double>(of)); }
double mega(std::size_t count) { return 1e-6 * static_cast<double>(count); }
double kilo(std::size_t count) { return 1e-3 * static_cast<double>(count); }

std::string title_of(const SceneResult& result, std::size_t s) { return title_of(kScenes[s].scene, result.is_stand_in); }

std::string table1(const std::vector<SceneResult>& results) {
  const std::string text = heading(
      "Table 1: soft-shadow rays, 16 samples on an area light, a tree with ten triangles a leaf; thousands of "
      "leaves and of frustums per million rays; and Figure 12: the speed of the pipeline, to the letter");
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
  const std::string text = heading("Figure 13: percentages of the stages, to the letter, and nanoseconds per ray in all");
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
  const std::string text = heading("Compression, sorting and decompression (CSD) against a plain radix sort, hashing included");
  TextTable table({"rays", "M rays", "rays/chunk", "CSD ns/ray", "plain ns/ray", "plain/CSD", "paper"});
  for (std::size_t s = 0; s < results.size(); ++s)
    for (int i = 0; i < kSorteds; ++i) {
      const SortTimes& t = results[s].sorts[i];
      const auto ns = [&](double ms) { return per(1e6 * ms, static_cast<double>(t.rays)); };
      table.add({title_of(results[s], s) + ", " + kSortedNames[i], number(mega(t.rays)), number(per(t.rays, t.chunks)),
                 number(ns(t.csd_ms)), number(ns(t.plain_ms)), number(per(t.plain_ms, t.csd_ms)),
                 i == kSamples ? print("~%g", kPaperCsd) : ""});
    }
  return text + table.text();
}

std::string walk_table(const std::vector<SceneResult>& results) {
  const std::string text = heading(
      "The frustums of soft-shadow rays through trees, on one thread: times as multiples of that "
      "of the Octo-BVH, breadth first, eight boxes at once in SIMD");
  TextTable table({"", "frustums", "leaves", "octo", "octo", "octo, scalar", "octo, scalar", "binary", "binary"});
  table.add({"", "k", "k", "breadth, ms", "depth", "breadth", "depth", "breadth", "depth"});
  for (std::size_t s = 0; s < results.size(); ++s) {
    const WalkTimes& w = results[s].walks;
    std::vector<std::string> row = {title_of(results[s], s), number(kilo(w.frustums)), number(kilo(w.leaves)),
                                    number(w.ms[kOcto])};
    for (int i = kOcto + 1; i < kWalks; ++i) row.push_back(number(per(w.ms[i], w.ms[kOcto])));
    table.add(row);
  }
  table.add({"paper", "", "", "", print("%g", kPaperDepthFirst), "", "", print("%g", kPaperBinary), ""});
  return text + table.text();
}

std::string figures14_15(const std::vector<SceneResult>& results) {
  const std::string text = heading(
      "Figures 14 and 15: the speed of depth-first single rays (sbvh/stack) in Mrays/s, and that of packets as "
      "multiples of it, by sbvh/breadth-first and to the letter; the letter's frustums at UCF .004, MaxSize 256");
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
  const std::string text = heading(
      "The SIMT model's prediction for a GPU: depth-first single rays (stack), the localized stage as in Fig. 10, a ray a "
      "lane, "
      "in the same warps, and with queues of boxes and triangles; steps a ray, lanes at work, and on tests that rays need, "
      "transactions a ray (distinct lines of 128 bytes and sectors of 32), and queue operations a step");
  TextTable table({"rays", "steps", "lanes", "needed", "boxes", "triangles", "lines", "sectors", "x stack", "queue"});
  const auto row = [](const std::string& name, const SimtProfile& p, const SimtProfile& stack) {
    const double rays = std::max(1.0, static_cast<double>(p.rays));
    const auto traffic = all_traffic(p);
    return std::vector<std::string>{name,
                                    number(kWarpSize * static_cast<double>(issued(p)) / rays),
                                    percent(p.efficiency()),
                                    "",
                                    percent(p.descend.efficiency()),
                                    percent(p.intersect.efficiency()),
                                    number(static_cast<double>(traffic.lines) / rays),
                                    number(static_cast<double>(traffic.sectors) / rays),
                                    number(per(traffic.sectors, all_traffic(stack).sectors))};
  };
  constexpr std::size_t kNeeded = 3;
  for (std::size_t s = 0; s < results.size(); ++s) {
    table.add({title_of(results[s], s)});
    for (int m = 0; m < kModels; ++m) {
      const ModelProfiles& p = results[s].models[m];
      table.add({print("  %s", kModelNames[m])});
      table.add(row("    stack", p.stack, p.stack));
      auto by_ray = row("    a ray a lane", p.localized, p.stack), queues = row("    queues", p.queues.simt, p.stack);
      by_ray[kNeeded] = percent(p.localized.efficiency()), queues[kNeeded] = percent(p.needed());
      queues.push_back(number(per(p.queues.queues.steps, issued(p.queues.simt))));
      table.add(by_ray), table.add(queues);
    }
  }
  return text + table.text();
}

std::string idle_table(const std::vector<SceneResult>& results) {
  const std::string text = heading(
      "Where lanes idle that have a ray each: percentages of all lanes in steps that test boxes, and in steps that test "
      "triangles, which are so many of all steps; lanes have missed the box whose triangles others test");
  TextTable table({"", "boxes:", "", "", "triangles:", "", "", "", ""});
  table.add({"rays", "at work", "no ray", "answered", "at work", "no ray", "answered", "missed", "steps"});
  for (std::size_t s = 0; s < results.size(); ++s) {
    table.add({title_of(results[s], s)});
    for (int m = 0; m < kModels; ++m) {
      const LaneUse &b = results[s].models[m].boxes, &t = results[s].models[m].triangles;
      table.add({print("  %s", kModelNames[m]), percent(b.share(b.at_work)), percent(b.share(b.have_no_ray)),
                 percent(b.share(b.are_answered)), percent(t.share(t.at_work)), percent(t.share(t.have_no_ray)),
                 percent(t.share(t.are_answered)), percent(t.share(t.have_missed_box)),
                 percent(per(t.steps, b.steps + t.steps))});
    }
  }
  return text + table.text();
}

constexpr char kSceneNote[] = R"(Scenes, views and lights are not the paper's: two rooms take the place of the Fairy
  Forest. The light is a quarter as wide as the library's default one, at which leaves per frustum are about those of the
  paper; "x 4" is the default light.)";
constexpr char kHashNote[] = R"(Besides the cell of the origin, hash values have the face (dominant axis and sign), which
  frustums need; towards lights that are enlarged, cells within the face, too. Rays without a face are traced one by one
  ("rest").)";
constexpr char kWalkNote[] = R"(On a CPU a stack lies in the nearest cache, while the queue of breadth-first traversal goes
  through memory once for each level, with the leaves found so far: depth-first traversal costs the paper's GPU five times as
  much, and less here. The binary tree is tested by scalar code; "octo, scalar" tells what part of the difference the arity
  has.)";
constexpr char kLiteralNote[] = R"("To the letter" is sorted and taken through one stage after the other as a whole, so that
  each stage streams all rays through memory. sbvh/breadth-first takes blocks that fit the caches, sorts where it pays, and
  leaves wide frustums to single rays.)";
constexpr char kModelNote[] = R"(A ray a lane: a warp goes through the list of leaves together; all lanes test a box, then
  those that entered it its triangles. So lanes idle that have missed the box, that have their answer, until the last ray of
  the warp has, or that have no ray, at the end of a packet; all triangles of a leaf are tested by the same lanes, so their
  number idles none. In Fig. 10, which has no exit for any-hit rays, all stay to the end. Sorting, frustums and traversal are
  not modelled.)";
constexpr char kQueueNote[] = R"(With queues (packet/localized_warp.h) lanes take boxes and triangles of 128 rays in hand, and
  warps 1024 rays each, of whatever packets. "Needed" counts a lane only for a test that its ray makes alone, too: rays that
  have met something meanwhile make others. Steps of several packets read more sectors than those of one. Steps are not
  instructions: a queue operation is some 25 by count of PTX, a box 70 to 105, a triangle 95 to 310. By that estimate queues
  spend what they save where any-hit rays meet many leaves, and cost up to twice the instructions for primary rays; no device
  has told yet.)";

std::string size_note(const Settings& settings) {
  return print(
      "Pictures have %u x %u pixels, the paper's 1024 x 768: with fewer hit points in a cell, small cells make small packets, "
      "more of them for each ray, and warps that are not full.",
      settings.size, settings.size);
}

std::string notes(const std::vector<SceneResult>& results, const Settings& settings) {
  return notes_title(results) + paragraph(kSceneNote) + paragraph(size_note(settings)) + paragraph(kHashNote) +
         paragraph(kWalkNote) + paragraph(kLiteralNote) + paragraph(kModelNote) + paragraph(kQueueNote);
}

Json row_named(const std::string& name, std::size_t s, const SceneResult& r) {
  return new_row("gl10", kScenes[s].scene, r.is_stand_in, name);
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

void add_lanes(const std::string& name, const LaneUse& use, Json& row) {
  row[name + "_at_work"] = use.share(use.at_work), row[name + "_no_ray"] = use.share(use.have_no_ray);
  row[name + "_answered"] = use.share(use.are_answered), row[name + "_missed_box"] = use.share(use.have_missed_box);
}

void add_model_rows(std::size_t s, const SceneResult& r, int model, Json& rows) {
  const ModelProfiles& m = r.models[model];
  const auto new_row_of = [&](const char* what, const SimtProfile& p) {
    Json row = row_named(std::string("simt/") + kModelNames[model] + "/" + what, s, r);
    row["rays"] = p.rays, row["simt_steps"] = issued(p), row["simt_efficiency"] = p.efficiency();
    row["simt_lines"] = all_traffic(p).lines, row["simt_sectors"] = all_traffic(p).sectors;
    return row;
  };
  rows.push_back(new_row_of("stack", m.stack));
  Json localized = new_row_of("localized", m.localized), queues = new_row_of("queues", m.queues.simt);
  add_lanes("boxes", m.boxes, localized), add_lanes("triangles", m.triangles, localized);
  queues["simt_needed"] = m.needed(), queues["queue_operations"] = m.queues.queues.steps;
  rows.push_back(localized), rows.push_back(queues);
}

void add_other_rows(std::size_t s, const SceneResult& r, Json& rows) {
  for (int i = 0; i < kSorteds; ++i) {
    const SortTimes& t = r.sorts[i];
    Json row = row_named(std::string("sort/") + kSortedNames[i], s, r);
    row["rays"] = t.rays, row["chunks"] = t.chunks, row["csd_ms"] = t.csd_ms, row["plain_ms"] = t.plain_ms;
    rows.push_back(row);
  }
  for (int w = 0; w < kWalks; ++w) {
    Json row = row_named(std::string("traversal/") + kWalkNames[w], s, r);
    row["frustums"] = r.walks.frustums, row["leaves"] = w < kBinary ? r.walks.leaves : r.walks.binary_leaves;
    row["ms"] = r.walks.ms[w];
    rows.push_back(row);
  }
  for (int m = 0; m < kModels; ++m) add_model_rows(s, r, m, rows);
}

}  // namespace

}  // namespace garanzha_loop

Result<Report> gl10(const Settings& settings) {
  using namespace garanzha_loop;
  const Result<std::vector<SceneResult>> measured = measure_all<SceneResult>(kScenes, measure, settings);
  if (!measured) return measured.error();
  const std::vector<SceneResult>& results = *measured;
  Report report;
  report.text = "Garanzha and Loop 2010, Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray Tracing\n" +
                table1(results) + figure13(results) + sort_table(results) + walk_table(results) + figures14_15(results) +
                simt_table(results) + idle_table(results) + notes(results, settings);
  for (std::size_t s = 0; s < results.size(); ++s) {
    add_grid_rows(s, results[s], report.rows);
    add_speed_rows(s, results[s], report.rows);
    add_other_rows(s, results[s], report.rows);
  }
  return report;
}

}  // namespace accel::paper_tables
