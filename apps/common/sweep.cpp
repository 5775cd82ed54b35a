#include "apps/common/sweep.h"

#include <algorithm>
#include <map>
#include <set>

#include "apps/common/rate_text.h"
#include "apps/common/table.h"
#include "apps/common/text.h"
#include "libaccel/rays/ray_kind.h"

namespace accel::apps {

namespace {

using validation::Rate;

const std::string& promised_test() { return triangle_tests().front(); }

// Whether a configuration says something that no other does: other tests are compared where a method is robust and has code for
// them, one thing at a time.
bool makes_sense(const AnyAccel& accel, const std::string& test) {
  if (test == promised_test()) return true;
  return accel.method().robust && accel.accepts(test).ok() && accel.is_tuned_for(test);
}

bool is_ours(const TraceRow& row) { return row.embree == nullptr; }

Rate failures_of(const TraceRow& row) { return row.check->rate_of(row.check->failures()); }

// The first where the second is not known.
Rate worse(const Rate& a, const Rate& b) {
  const bool is_tie = a.per_million == b.per_million;
  return b.per_million > a.per_million || (is_tie && b.bound95_per_million > a.bound95_per_million) ? b : a;
}

// By what it traces with: "sbvh/stack + woop", "Embree/robust".
std::map<std::string, const TraceRow*> edge_rows(const TraceReport& report) {
  std::map<std::string, const TraceRow*> rows;
  for (const TraceRow& row : report.rows)
    if (row.rays_kind == info(RayKind::edge).name && row.check) rows[row.configuration()] = &row;
  return rows;
}

bool dominates(const SweepPoint& a, const SweepPoint& b) {
  const bool as_good = a.ns_per_ray <= b.ns_per_ray && a.error.per_million <= b.error.per_million;
  return as_good && (a.ns_per_ray < b.ns_per_ray || a.error.per_million < b.error.per_million);
}

// The rows that are on a kind's plane, the fastest first.
template <class Report>
auto rows_of(Report& report, const std::string& kind) {
  std::vector<decltype(&report.rows.front())> rows;
  for (auto& row : report.rows)
    if (row.rays_kind == kind && row.point) rows.push_back(&row);
  std::sort(rows.begin(), rows.end(), [](auto a, auto b) { return a->point->ns_per_ray < b->point->ns_per_ray; });
  return rows;
}

// "no wrong hit found (fewer than 15.3 per million)", "3194 wrong hits per million".
std::string error_text(const Rate& rate) {
  if (rate.per_million > 0) return short_number(rate.per_million) + " wrong hits per million";
  return "no wrong hit found (fewer than " + short_number(rate.bound95_per_million) + " per million)";
}

std::string t_text(const TraceRow& row) {
  if (row.check->errors.samples == 0) return {};
  return ", t within " + short_number(row.check->errors.t_ulp_max) + " ulp";
}

// Whether the error is known to be within a bound: by promise, or by enough rays without an error.
bool is_within(const TraceRow& row, double most) {
  const Rate& error = row.point->error;
  return error.per_million <= most && (row.promised || error.bound95_per_million <= most);
}

std::string advice_text(const std::vector<TraceRow*>& rows, const std::string& kind, const TraceSettings& settings) {
  const double most = settings.max_error.value_or(0);
  const auto first = [&](const auto& condition) -> const TraceRow* {
    const auto found =
        std::find_if(rows.begin(), rows.end(), [&](const TraceRow* row) { return is_ours(*row) && condition(*row); });
    return found == rows.end() ? nullptr : *found;
  };
  const TraceRow* best = first([&](const TraceRow& row) { return is_within(row, most); });
  if (best == nullptr)
    return "nothing that was tried is known to have at most " + short_number(most) + " wrong hits per million";
  std::string text = "for this scene and " + kind + " rays, use " + best->configuration() + ": " +
                     short_number(best->point->ns_per_ray) + " ns a ray, " + error_text(best->point->error) + t_text(*best);
  const TraceRow* fastest = first([](const TraceRow&) { return true; });
  if (fastest == best) return text + "; nothing that was tried is faster";
  const double gain = 100 * (best->point->ns_per_ray / fastest->point->ns_per_ray - 1);
  return text + "; " + fastest->configuration() + " is " + print(gain < 9.5 ? "%.1f" : "%.0f", gain) + " % faster, with " +
         error_text(fastest->point->error) + t_text(*fastest);
}

std::string ulp_cell(const TraceRow& row, double ulp) { return row.check->errors.samples > 0 ? short_number(ulp) : ""; }

// What is worth a line: the front, Embree, and of each structure the fastest configuration that is promised.
class WorthALine {
 public:
  explicit WorthALine(bool all) : all_(all) {}

  // Of rows that come in the order of their speed.
  bool operator()(const TraceRow& row) {
    const bool is_first_of_structure = row.promised && structures_.insert(row.structure).second;
    return all_ || row.point->on_front || !is_ours(row) || is_first_of_structure;
  }

 private:
  bool all_;
  std::set<std::size_t> structures_;
};

std::string plane_table(const TraceReport& report, const std::string& kind, bool all) {
  Table table({{"", Table::Align::left},
               {"configuration", Table::Align::left},
               {"ns/ray"},
               {"instr."},
               {"x Embree"},
               {"wrong/M"},
               {"leaks/M"},
               {"ulp p99"},
               {"max"},
               {"B/tri"}});
  const TraceRow* embree = report.embree_row(kind);
  const auto triangles = static_cast<double>(std::max<std::uint64_t>(report.triangles, 1));
  WorthALine is_worth_a_line(all);
  std::size_t hidden = 0;
  for (const TraceRow* row : rows_of(report, kind)) {
    if (!is_worth_a_line(*row)) {
      ++hidden;
      continue;
    }
    const SweepPoint& point = *row->point;
    const StructureRow& structure = report.structures[row->structure];
    const auto& errors = row->check->errors;
    table.add_row({point.on_front ? "*" : "", row->configuration(), short_number(point.ns_per_ray),
                   row->instructions ? short_number(*row->instructions) : "",
                   embree != nullptr && embree->point ? print("%.2f", embree->point->ns_per_ray / point.ns_per_ray) : "",
                   rate_text(point.error), rate_text(point.leaks), ulp_cell(*row, errors.t_ulp_p99),
                   ulp_cell(*row, errors.t_ulp_max), short_number(static_cast<double>(structure.bytes) / triangles)});
  }
  if (hidden == 0) return table.text();
  return table.text() + "  " + counted(hidden, "configuration") + (hidden == 1 ? " that is" : " that are") +
         " slower and no better left out; --verbose and --json have all\n";
}

}  // namespace

std::vector<Configuration> configurations(const MethodSet& set, const TraceSettings& settings, std::vector<Skip>& skipped) {
  std::vector<Configuration> result;
  std::size_t left_out = 0;
  for (const MethodSet::Member& member : set.members) {
    if (!settings.sweep) {
      result.push_back({&member, settings.test, true});
      continue;
    }
    for (const std::string& test : triangle_tests()) {
      if (!settings.test.empty() && test != settings.test) continue;
      if (makes_sense(member.accel, test))
        result.push_back({&member, test, member.accel.method().robust && test == promised_test()});
      else
        ++left_out;
    }
  }
  if (left_out > 0) skipped.push_back({counted(left_out, "combination"), "the method serves the first triangle test alone"});
  return result;
}

void place_on_plane(TraceReport& report, const TraceSettings& settings) {
  const auto edges = edge_rows(report);
  for (TraceRow& row : report.rows) {
    if (!row.check || !(row.speed.median > 0)) continue;
    SweepPoint point;
    point.ns_per_ray = 1e3 / row.speed.median;
    point.error = failures_of(row);
    if (const auto edge = edges.find(row.configuration()); edge != edges.end()) {
      point.edge_error = failures_of(*edge->second);
      point.leaks = edge->second->check->rate_of(edge->second->check->ours.miss);
      point.error = worse(point.error, point.edge_error);
    }
    row.point = point;
  }
  std::vector<std::string> kinds;  // as rows have them
  for (const TraceRow& row : report.rows)
    if (std::find(kinds.begin(), kinds.end(), row.rays_kind) == kinds.end()) kinds.push_back(row.rays_kind);
  for (const std::string& kind : kinds) {
    const auto rows = rows_of(report, kind);
    for (TraceRow* row : rows)
      row->point->on_front = is_ours(*row) && std::none_of(rows.begin(), rows.end(), [&](const TraceRow* other) {
                               return is_ours(*other) && dominates(*other->point, *row->point);
                             });
    if (!rows.empty()) report.advice.push_back({kind, advice_text(rows, kind, settings)});
  }
}

std::string sweep_section(const TraceReport& report, const TraceSettings& settings, const Terminal& terminal) {
  std::string text;
  for (const Advice& advice : report.advice) {
    text += "\n" + terminal.styled("Run time against error, " + advice.rays_kind + " rays", Style::strong) +
            "  (* on the front; errors of these and of edge rays)\n" +
            plane_table(report, advice.rays_kind, settings.common.verbosity == Verbosity::verbose);
    text += wrapped("Advice: " + advice.text, kTableWidth, "  ");
  }
  return text;
}

}  // namespace accel::apps
