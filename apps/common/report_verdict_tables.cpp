// The tables of report_tables.h that tell who is right.
#include <algorithm>
#include <initializer_list>

#include "apps/common/report_tables.h"
#include "apps/common/text.h"

namespace accel::apps {

namespace {

// Methods whose numbers are the same share a row: most of them are judged alike.
struct Alike {
  const ReportRow* row;
  std::vector<std::string> labels;
};

// Their names, or where these are many and no other group is larger: how many they are.
std::string names_of(const Alike& alike, const std::vector<Alike>& all) {
  const auto is_smaller = [&](const Alike& other) { return &other == &alike || other.labels.size() < alike.labels.size(); };
  if (alike.labels.size() < 4 || !std::all_of(all.begin(), all.end(), is_smaller)) return join(alike.labels, ", ");
  return (all.size() == 1 ? "all " : "the other ") + std::to_string(alike.labels.size()) + " methods";
}

// The rows of a kind of rays that are checked, put together where all of these keys are the same.
std::vector<Alike> alike_rows(const ReportData& data, const std::string& kind, std::initializer_list<const char*> keys) {
  std::vector<Alike> found;
  const auto value = [](const ReportRow& row, const char* key) { return row.json->contains(key) ? (*row.json)[key] : Json(); };
  for (const ReportRow* row : data.rows(kind)) {
    if (!row->json->contains("verdicts")) continue;
    const auto is_same = [&](const Alike& other) {
      return std::all_of(keys.begin(), keys.end(), [&](const char* key) { return value(*row, key) == value(*other.row, key); });
    };
    const auto same = std::find_if(found.begin(), found.end(), is_same);
    if (same == found.end())
      found.push_back({row, {row->label}});
    else
      same->labels.push_back(row->label);
  }
  return found;
}

std::vector<HtmlCell> verdict_cells(const ReportData& data, const ReportRow& row, const char* key, const std::string& engine) {
  std::vector<HtmlCell> cells = {row_head(engine)};
  for (const char* verdict : {"agree", "judged", "right", "neighbour", "edge"})
    cells.push_back(data.cell(row.pointer(std::string(key) + "/" + verdict), count_text));
  for (const char* verdict : {"miss", "far", "false"})
    cells.push_back(data.failures_cell(row.pointer(std::string(key) + "/" + verdict)));
  return cells;
}

// Methods that are judged by other truths have another witness: one line serves its neighbours only where it is the same.
bool needs_witness_row(const std::vector<Alike>& rows, std::size_t i) {
  const Json& mine = *rows[i].row->json;
  if (!mine.contains("embree_verdicts")) return false;
  return i + 1 == rows.size() || rows[i + 1].row->json->value("embree_verdicts", Json()) != mine["embree_verdicts"];
}

void add_verdicts(HtmlTable& table, const ReportData& data, const std::string& kind) {
  const std::vector<Alike> rows = alike_rows(data, kind, {"verdicts", "unjudged", "embree_verdicts"});
  if (!rows.empty()) table.begin_group(rays_of_kind(kind));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ReportRow& row = *rows[i].row;
    std::vector<HtmlCell> ours = verdict_cells(data, row, "verdicts", names_of(rows[i], rows));
    ours.push_back(data.cell(row.pointer("unjudged"), [](double n) { return n > 0 ? count_text(n) : std::string(); }));
    ours.push_back(data.rate_cell(row.pointer("wrong_per_million"), row.pointer("wrong_per_million_bound95")));
    table.add_row(std::move(ours));
    if (!needs_witness_row(rows, i)) continue;
    std::vector<HtmlCell> witness = verdict_cells(data, row, "embree_verdicts", "Embree robust");
    witness.push_back(words(""));
    witness.push_back(data.witness_wrong_cell(row));
    table.add_row(std::move(witness), "reference");
  }
}

std::vector<HtmlCell> adjudication_cells(const ReportData& data, const Alike& alike, const std::vector<Alike>& all) {
  const auto at = [&](const std::string& key) { return alike.row->pointer(key); };
  std::vector<HtmlCell> cells = {row_head(names_of(alike, all))};
  for (const char* key : {"both_right", "only_ours_right", "only_embree_right", "both_wrong"})
    cells.push_back(data.cell(at(std::string("adjudication/") + key), count_text));
  for (const char* key : {"mean", "p50", "p99", "max"}) cells.push_back(data.cell(at(std::string("t_ulp/") + key), hundredths));
  cells.push_back(data.cell(at("barycentric_error_max"), short_number));
  return cells;
}

bool have_witness(const ReportData& data) { return data.any_row_has("embree_verdicts"); }

}  // namespace

std::string verdicts_table(const ReportData& data) {
  const std::string judged =
      have_witness(data)
          ? "Agreement with the witness is taken as right, and a sample of it judged in exact arithmetic; all else "
            "is judged. "
          : "Every ray is judged in exact arithmetic. ";
  HtmlTable table(
      "<b>Verdicts.</b> " + judged +
          "<i>neighbour</i> and <i>edge</i> are answers within the proved bound of rounding; <i>miss</i>, <i>far</i> and "
          "<i>false</i> are wrong. Where none is wrong, the rate is below 3/N with 95 % confidence; N leaves out what was not "
          "judged.",
      {{"engine", true},
       {"agree"},
       {"judged"},
       {"right"},
       {"neighbour"},
       {"edge"},
       {"miss"},
       {"far"},
       {"false"},
       {"not judged"},
       {"wrong per million"}});
  for (const std::string& kind : data.kinds()) add_verdicts(table, data, kind);
  return table.empty() ? "" : table.html();
}

std::string adjudication_table(const ReportData& data) {
  HtmlTable table(std::string("<b>Adjudication.</b> ") +
                      (have_witness(data) ? "Who was right on the judged rays, and how" : "How") +
                      " far the t of right hits is from the exact one, in units in the last place.",
                  {{"method", true},
                   {"both right"},
                   {"only ours"},
                   {"only Embree"},
                   {"neither"},
                   {"t error, mean ulp"},
                   {"median"},
                   {"p99"},
                   {"most"},
                   {"barycentric, most"}});
  for (const std::string& kind : data.kinds()) {
    const std::vector<Alike> rows = alike_rows(data, kind, {"adjudication", "t_ulp", "barycentric_error_max"});
    if (!rows.empty()) table.begin_group(rays_of_kind(kind));
    for (const Alike& alike : rows) table.add_row(adjudication_cells(data, alike, rows));
  }
  return table.empty() ? "" : table.html();
}

}  // namespace accel::apps
