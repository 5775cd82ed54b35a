#include "apps/common/trace_report.h"

#include <algorithm>

#include "apps/common/rate_text.h"
#include "apps/common/scaling.h"
#include "apps/common/sweep.h"
#include "apps/common/table.h"
#include "apps/common/text.h"
#include "libaccel/registry/any_accel.h"

namespace accel::apps {

namespace {

using Align = Table::Align;
using validation::CheckResult;
using validation::Verdicts;

constexpr const char* kMemoryClassNames[kMemoryClasses] = {"node", "tri", "stack", "hash", "ray"};

std::string per_ray(std::uint64_t sum, std::uint64_t rays) {
  return rays == 0 ? "" : short_number(static_cast<double>(sum) / static_cast<double>(rays));
}

std::string vec_text(Vec3 v) { return "(" + short_number(v.x) + " " + short_number(v.y) + " " + short_number(v.z) + ")"; }

template <class Condition>
bool any_row(const TraceReport& report, Condition condition) {
  return std::any_of(report.rows.begin(), report.rows.end(), condition);
}

bool have_witness(const TraceReport& report) {
  return any_row(report, [](const TraceRow& row) { return row.check && row.check->has_witness; });
}

// "miss 2, false 1": the kinds of failures that occurred.
std::string failures_text(const Verdicts& v) {
  std::vector<std::string> parts;
  for (const auto& [name, count] : {std::pair{"miss", v.miss}, {"far", v.far}, {"false", v.false_hit}})
    if (count > 0) parts.push_back(std::string(name) + " " + with_commas(count));
  return join(parts, ", ");
}

std::string section(const Terminal& terminal, const std::string& title) {
  return "\n" + terminal.styled(title, Style::strong) + "\n";
}

// The first thing to see where something is wrong.
std::string failures_section(const TraceReport& report, const Terminal& terminal) {
  if (report.failures() == 0) return {};
  std::string text = terminal.styled("WRONG HITS", Style::bad) + "\n";
  for (const TraceRow& row : report.rows) {
    if (!row.check || !row.promised || row.check->failures() == 0) continue;
    text += "  " + row.method + ", " + row.rays_kind + ": " + counted(row.check->failures(), "ray") + " of " +
            with_commas(row.rays) + " wrong (" + failures_text(row.check->ours) + ")\n";
    const auto& first = row.check->first_failures;
    for (std::size_t i = 0; i < std::min<std::size_t>(first.size(), 5); ++i)
      text += print("    ray %zu: %s\n", first[i].ray, std::string(to_string(first[i].verdict)).c_str());
    if (!row.repro.empty()) text += "    to reproduce: " + row.repro + "\n";
  }
  for (const SortRow& row : report.sorts)
    if (row.different > 0)
      text += "  " + row.method + ", " + row.rays_kind + ": " + counted(row.different, "answer") + " of " +
              with_commas(row.rays) + " changed when the rays were sorted\n";
  return text + "\n";
}

std::string scene_section(const TraceReport& report, const TraceSettings& settings, const Terminal& terminal) {
  const CameraDescription& camera = report.camera;
  std::string text = terminal.styled(report.scene, Style::strong) + "  " + counted(report.triangles, "triangle") +
                     ", loaded in " + seconds_text(report.load_seconds) + "\n";
  const Aabb& box = report.facts.bounds;
  text += box.empty() ? "  nothing that a ray can hit\n" : "  box " + vec_text(box.lo) + " to " + vec_text(box.hi) + "\n";
  text += "  camera " + (camera.name.empty() ? "" : "'" + camera.name + "' ") + "at " + vec_text(camera.eye) + " towards " +
          vec_text(camera.at) + ", vfov " + short_number(camera.vfov_degrees) + "\n";
  text += print("  %u x %u pixels%s, %s a pixel, seed %llu, %s%s\n", settings.width, settings.height,
                settings.pixel_order == PixelOrder::z_curve ? " along a Z-curve" : "", counted(settings.spp, "ray").c_str(),
                static_cast<unsigned long long>(settings.common.seed),
                counted(static_cast<std::uint64_t>(report.threads), "thread").c_str(),
                report.device == "cpu" ? "" : (", methods on " + report.device).c_str());
  return text + "  " + report.checked_by + "\n";
}

std::string structures_section(const TraceReport& report, const Terminal& terminal) {
  Table table({{"STRUCTURE", Align::left}, {"build"}, {"memory"}, {"triangles"}, {"references"}, {"SAH cost"}, {"depth"}});
  for (const StructureRow& row : report.structures) {
    const bool ours = row.report.triangles > 0 || row.report.references > 0;
    table.add_row({row.name, row.build_seconds > 0 ? seconds_text(row.build_seconds) : "", bytes_text(row.bytes),
                   ours ? with_commas(row.report.triangles) : "", ours ? with_commas(row.report.references) : "",
                   row.facts.sah_cost ? short_number(*row.facts.sah_cost) : "",
                   row.facts.depth ? std::to_string(*row.facts.depth) : ""});
  }
  return section(terminal, "Structures") + table.text();
}

std::string verdict_cell(const TraceRow& row, const Terminal& terminal) {
  if (!row.check) return row.embree != nullptr ? "" : "not checked";
  if (row.check->failures() > 0) return terminal.styled(with_commas(row.check->failures()) + " WRONG", Style::bad);
  return terminal.styled(row.check->limit_binds() ? "right so far" : "all right", Style::good);
}

// Exact up to a million, which keeps the column narrow; the JSON has all digits.
std::string short_count(std::uint64_t n) {
  return n < 1000000 ? with_commas(n) : print("%.2f M", static_cast<double>(n) * 1e-6);
}

// Five characters at most: a slow method must not make the table wider than a terminal.
std::string speed_text(double mrays) {
  if (mrays >= 0.0995) return short_number(mrays);
  return print(mrays >= 0.0095 ? "%.2f" : "%.0e", mrays);
}

// A speed as a multiple of that of a row of Embree; nothing where either is missing.
std::string ratio_text(const TraceRow& row, const TraceRow* embree) {
  if (embree == nullptr || !(row.speed.median > 0) || !(embree->speed.median > 0)) return {};
  return print("%.2f", row.speed.median / embree->speed.median);
}

std::string speed_section(const TraceReport& report, const TraceSettings& settings, const Terminal& terminal) {
  Table table({{"RAYS", Align::left},
               {"method", Align::left},
               {"rays"},
               {"Mrays/s"},
               {"min - max"},
               {"x Embree"},
               {"nodes"},
               {"tests"},
               {"hits", Align::left}});
  const std::string* kind = nullptr;
  for (const TraceRow& row : report.rows) {
    const bool first = kind == nullptr || *kind != row.rays_kind;
    kind = &row.rays_kind;
    const bool timed = row.speed.median > 0;
    table.add_row(
        {first ? row.rays_kind : "", row.method, first ? short_count(row.rays) : "", timed ? speed_text(row.speed.median) : "",
         timed ? speed_text(row.speed.least) + " - " + speed_text(row.speed.most) : "",
         ratio_text(row, report.embree_row(row.rays_kind)), row.counters ? per_ray(row.counters->node_steps, row.rays) : "",
         row.counters ? per_ray(row.counters->triangle_tests, row.rays) : "", verdict_cell(row, terminal)});
  }
  const char* asked = !settings.query                 ? ""
                      : *settings.query == Query::any ? "; all ask for any hit"
                                                      : "; all ask for the closest";
  return section(terminal, "Speed, median of " + counted(static_cast<std::uint64_t>(settings.repeat), "run") +
                               " in turns; nodes and tests a ray" + asked) +
         table.text();
}

// What the modes of Embree are.
std::string embree_legend(const std::vector<const TraceRow*>& modes) {
  std::string text;
  bool tiled = false;
  for (const TraceRow* row : modes) {
    text += "  " + row->method + ": " + std::string(row->embree->what) + "\n";
    tiled = tiled || takes_tiles(*row->embree);
  }
  if (tiled) text += "  Packets and streams: rays by tiles of pixels, in Embree's layout before the clock starts\n";
  return text;
}

// Methods against the fastest of several modes.
std::string best_embree_section(const TraceReport& report, const Terminal& terminal) {
  Table table({{"RAYS", Align::left}, {"method", Align::left}, {"x Embree"}, {"x best"}, {"fastest mode", Align::left}});
  for (const TraceRow& row : report.rows) {
    const TraceRow* const best = report.best_embree_row(row.rays_kind);
    if (row.embree != nullptr || best == nullptr) continue;
    table.add_row(
        {row.rays_kind, row.method, ratio_text(row, report.embree_row(row.rays_kind)), ratio_text(row, best), best->method});
  }
  return section(terminal, "Against the fastest mode of Embree for the rays") + table.text() +
         embree_legend(report.embree_rows(report.rows.front().rays_kind));
}

void add_verdict_row(Table& table, const std::string& kind, const std::string& engine, const Verdicts& v,
                     const CheckResult& check, const Terminal& terminal) {
  const auto bad = [&](std::uint64_t count) {
    return count == 0 ? std::string("0") : terminal.styled(with_commas(count), Style::bad);
  };
  table.add_row({kind, engine, with_commas(v.agree), with_commas(v.right), with_commas(v.neighbour), with_commas(v.edge),
                 bad(v.miss), bad(v.far), bad(v.false_hit), rate_text(check.rate_of(v.failures()))});
}

// Whether one line about the witness serves both. Methods that are judged by other truths have another witness.
bool have_same_witness(const TraceRow& a, const TraceRow& b) {
  return a.rays_kind == b.rays_kind && b.check->has_witness && a.check->witness == b.check->witness;
}

std::string verdict_section(const TraceReport& report, const Terminal& terminal) {
  Table table({{"RAYS", Align::left},
               {"engine", Align::left},
               {"agree"},
               {"right"},
               {"neighb."},
               {"edge"},
               {"miss"},
               {"far"},
               {"false"},
               {"wrong/M"}});
  std::string limits;
  std::vector<const TraceRow*> rows;
  for (const TraceRow& row : report.rows)
    if (row.check) rows.push_back(&row);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TraceRow& row = *rows[i];
    if (row.check->limit_binds())
      limits += "  " + row.method + ", " + row.rays_kind + ": --judge-limit left " + counted(row.check->unjudged, "ray") +
                " unjudged\n";
    add_verdict_row(table, row.rays_kind, row.method, row.check->ours, *row.check, terminal);
    if (row.check->has_witness && !(i + 1 < rows.size() && have_same_witness(row, *rows[i + 1])))
      add_verdict_row(table, "", "Embree robust", row.check->witness, *row.check, terminal);
  }
  const bool has_witness = have_witness(report);
  return section(terminal,
                 has_witness
                     ? "Verdicts: agreement with the witness is taken as right, a sample of it judged; all else is judged"
                     : "Verdicts: every ray is judged exactly") +
         table.text() + limits;
}

// Hundredths are enough, and keep the columns narrow.
std::string ulp_text(double ulp) { return ulp < 100 ? print("%.2f", ulp) : short_number(ulp); }

std::string adjudication_section(const TraceReport& report, const Terminal& terminal) {
  Table table({{"RAYS", Align::left},
               {"method", Align::left},
               {"both"},
               {"only ours"},
               {"only Embree"},
               {"neither"},
               {"ulp mean"},
               {"p99"},
               {"max"}});
  for (const TraceRow& row : report.rows) {
    if (!row.check) continue;
    const auto& a = row.check->adjudication;
    const auto& e = row.check->errors;
    const bool two = row.check->has_witness, measured = e.samples > 0;
    table.add_row({row.rays_kind, row.method, two ? with_commas(a.both_right) : "", two ? with_commas(a.only_ours_right) : "",
                   two ? with_commas(a.only_witness_right) : "", two ? with_commas(a.both_wrong) : "",
                   measured ? ulp_text(e.t_ulp_mean) : "", measured ? ulp_text(e.t_ulp_p99) : "",
                   measured ? ulp_text(e.t_ulp_max) : ""});
  }
  const bool has_witness = have_witness(report);
  return section(terminal, has_witness
                               ? "Adjudication of judged rays: who was right, and the error of t against exact arithmetic"
                               : "The error of t of judged rays against exact arithmetic") +
         table.text();
}

std::string simt_section(const TraceReport& report, const Terminal& terminal) {
  Table table({{"RAYS", Align::left},
               {"method", Align::left},
               {"all"},
               {"descend"},
               {"intersect"},
               {"backtrack"},
               {"lines/ray"},
               {"bytes/ray by class", Align::left}});
  const auto percent = [](double share) { return print("%.1f %%", 100 * share); };
  for (const TraceRow& row : report.rows) {
    if (!row.simt) continue;
    const SimtProfile& p = *row.simt;
    std::uint64_t lines = 0;
    std::vector<std::string> bytes;
    for (int c = 0; c < kMemoryClasses; ++c) {
      lines += p.traffic[c].lines;
      if (p.traffic[c].bytes > 0)
        bytes.push_back(std::string(kMemoryClassNames[c]) + " " + per_ray(p.traffic[c].bytes, p.rays));
    }
    table.add_row({row.rays_kind, row.method, percent(p.efficiency()), percent(p.descend.efficiency()),
                   percent(p.intersect.efficiency()), percent(p.backtrack.efficiency()), per_ray(lines, p.rays),
                   join(bytes, ", ")});
  }
  return section(terminal, "SIMT profile: share of 32 lanes at work, distinct 128-byte lines") + table.text();
}

// Rays that a kernel ran for, per ray.
std::string steps_cell(const MultipassProfile& p, MultipassKernel kernel) { return per_ray(p.of(kernel).rays, p.rays); }

std::string multipass_section(const TraceReport& report, const TraceSettings& settings, const Terminal& terminal) {
  Table table({{"RAYS", Align::left},
               {"method", Align::left},
               {"passes"},
               {"switches"},
               {"at work"},
               {"down"},
               {"up"},
               {"tests"},
               {"trans."},
               {"recirculated"},
               {"fetched"}});
  for (const TraceRow& row : report.rows) {
    if (!row.multipass) continue;
    const MultipassProfile& p = *row.multipass;
    const MultipassProfile::KernelPasses all = p.total();
    table.add_row({row.rays_kind, row.method, with_commas(all.passes), with_commas(p.switches),
                   short_number(100 * all.utilisation()) + " %", steps_cell(p, MultipassKernel::down),
                   steps_cell(p, MultipassKernel::up), steps_cell(p, MultipassKernel::intersect),
                   per_ray(p.transitions(), p.rays), per_ray(all.bytes_recirculated(), p.rays),
                   per_ray(all.bytes_fetched, p.rays)});
  }
  const MultipassOptions& options = settings.multipass;
  return section(terminal, std::string("Multipass profile (") + rule_name(options.rule) + (options.compact ? ", compact" : "") +
                               ", " + with_commas(options.batch_size) + " rays in flight): steps and bytes per ray") +
         table.text();
}

std::string sort_section(const TraceReport& report, const TraceSettings& settings, const Terminal& terminal) {
  Table table({{"RAYS", Align::left},
               {"method", Align::left},
               {"chunks"},
               {"hash"},
               {"sort"},
               {"copy"},
               {"Mrays/s"},
               {"sorted"},
               {"gain"},
               {"in all"},
               {"gain"},
               {"hits", Align::left}});
  for (const SortRow& row : report.sorts) {
    const auto ns = [&](double seconds) {
      return short_number(1e9 * seconds / static_cast<double>(std::max<std::uint64_t>(row.rays, 1)));
    };
    const double before = std::max(row.as_they_came.median, 1e-9);
    table.add_row({row.rays_kind, row.method, short_count(row.chunks), ns(row.cost.hash), ns(row.cost.sort), ns(row.cost.copy),
                   short_number(row.as_they_came.median), short_number(row.sorted.median),
                   print("%.2f", row.sorted.median / before), short_number(row.sorted_in_all()),
                   print("%.2f", row.sorted_in_all() / before),
                   row.different == 0 ? terminal.styled("the same", Style::good)
                                      : terminal.styled(with_commas(row.different) + " DIFFER", Style::bad)});
  }
  return section(terminal,
                 std::string("Sorted by ") + name_of(*settings.sort) + ": cost in ns a ray; speed without it, and in all") +
         table.text();
}

std::string skipped_section(const TraceReport& report) {
  std::string text;
  for (const Skip& skip : report.skipped) text += "  skipped: " + skip.what + ", because " + skip.why + "\n";
  return text.empty() ? text : "\n" + text;
}

std::string explanations(const TraceReport& report) {
  std::string text;
  for (const BuildNote& note : report.notes) text += "  " + note.what + ": " + note.why + "\n";
  return text.empty() ? "\n  nothing was left out\n" : "\n" + text;
}

}  // namespace

std::string TraceRow::configuration() const {
  return test.empty() || test == triangle_tests().front() ? method : method + " + " + test;
}

std::uint64_t TraceReport::failures() const {
  std::uint64_t sum = 0;
  for (const TraceRow& row : rows) sum += row.check && row.promised ? row.check->failures() : 0;
  for (const SortRow& row : sorts) sum += row.different;
  return sum;
}

double SortRow::sorted_in_all() const {
  const double mrays = static_cast<double>(rays) * 1e-6;
  return sorted.median > 0 ? mrays / (mrays / sorted.median + cost.total()) : 0;
}

std::vector<const TraceRow*> TraceReport::embree_rows(const std::string& rays_kind) const {
  std::vector<const TraceRow*> found;
  for (const TraceRow& row : rows)
    if (row.embree != nullptr && row.rays_kind == rays_kind) found.push_back(&row);
  return found;
}

const TraceRow* TraceReport::embree_row(const std::string& rays_kind) const {
  const auto found = embree_rows(rays_kind);
  return found.empty() ? nullptr : found.front();
}

const TraceRow* TraceReport::best_embree_row(const std::string& rays_kind) const {
  const auto found = embree_rows(rays_kind);
  if (found.size() < 2) return nullptr;
  const auto is_slower = [](const TraceRow* a, const TraceRow* b) { return a->speed.median < b->speed.median; };
  return *std::max_element(found.begin(), found.end(), is_slower);
}

std::string report_text(const TraceReport& report, const TraceSettings& settings, const Terminal& terminal) {
  const bool checked = any_row(report, [](const TraceRow& row) { return row.check.has_value(); });
  const bool in_warps = any_row(report, [](const TraceRow& row) { return row.simt.has_value(); });
  const bool in_passes = any_row(report, [](const TraceRow& row) { return row.multipass.has_value(); });
  std::string text =
      failures_section(report, terminal) + scene_section(report, settings, terminal) + structures_section(report, terminal);
  const std::string scaling = report.scaling.empty() ? "" : scaling_section(report, terminal);
  if (settings.sweep)
    return text + sweep_section(report, settings, terminal) + scaling + (settings.explain ? explanations(report) : "") +
           skipped_section(report);
  text += speed_section(report, settings, terminal);
  const bool has_modes = any_row(report, [&](const TraceRow& row) { return report.best_embree_row(row.rays_kind) != nullptr; });
  if (has_modes) text += best_embree_section(report, terminal);
  text += scaling;
  if (!report.sorts.empty()) text += sort_section(report, settings, terminal);
  if (checked) text += verdict_section(report, terminal) + adjudication_section(report, terminal);
  if (in_warps) text += simt_section(report, terminal);
  if (in_passes) text += multipass_section(report, settings, terminal);
  if (settings.explain) text += explanations(report);
  return text + skipped_section(report);
}

}  // namespace accel::apps
