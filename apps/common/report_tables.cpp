#include "apps/common/report_tables.h"

#include "apps/common/text.h"

namespace accel::apps {

namespace {

std::string rays_of_kind(const std::string& kind) { return kind.ends_with(".npy") ? kind : kind + " rays"; }

// A table of our rows by kind of rays: those that `has` says, with the cells that `cells` returns.
template <class Has, class Cells>
void add_by_kind(HtmlTable& table, const ReportData& data, const Has& has, const Cells& cells) {
  for (const std::string& kind : data.kinds()) {
    bool is_first = true;
    for (const ReportRow* row : data.rows(kind)) {
      if (!has(*row)) continue;
      if (is_first) table.begin_group(rays_of_kind(kind));
      is_first = false;
      table.add_row(cells(*row), row->is_embree ? "reference" : "");
    }
  }
}

template <class Has, class Cells>
std::string by_kind(HtmlTable table, const ReportData& data, const Has& has, const Cells& cells) {
  add_by_kind(table, data, has, cells);
  return table.empty() ? "" : table.html();
}

// Whether rows have a key.
auto with(const char* key) {
  return [key](const ReportRow& row) { return row.json->contains(key); };
}

std::string rate_text(const ReportData::Wrong& wrong) {
  return wrong.rate > 0 ? short_number(wrong.rate) : "< " + short_number(wrong.bound);
}

HtmlCell witness_rate_cell(const ReportRow& row) {
  const auto wrong = ReportData::witness_wrong(row);
  HtmlCell cell{wrong ? rate_text(*wrong) : "", HtmlCell::Kind::number};
  if (wrong && wrong->rate > 0) cell.style = "bad";
  return cell;
}

// A count that should be 0.
HtmlCell failures_cell(const ReportData& data, const std::string& pointer) {
  HtmlCell cell = data.cell(pointer, count_text);
  if (data.number(pointer).value_or(0) > 0) cell.style = "bad";
  return cell;
}

std::vector<HtmlCell> verdict_cells(const ReportData& data, const ReportRow& row, const char* key, const std::string& engine) {
  std::vector<HtmlCell> cells = {row_head(engine)};
  for (const char* verdict : {"agree", "judged", "right", "neighbour", "edge"})
    cells.push_back(data.cell(row.pointer(std::string(key) + "/" + verdict), count_text));
  for (const char* verdict : {"miss", "far", "false"})
    cells.push_back(failures_cell(data, row.pointer(std::string(key) + "/" + verdict)));
  return cells;
}

// Methods that are judged by other truths have another witness: one line serves its neighbours only where it is the same.
bool next_has_same_witness(const std::vector<const ReportRow*>& rows, std::size_t i) {
  return i + 1 < rows.size() && rows[i + 1]->json->contains("embree_verdicts") &&
         (*rows[i + 1]->json)["embree_verdicts"] == (*rows[i]->json)["embree_verdicts"];
}

void add_verdicts(HtmlTable& table, const ReportData& data, const std::string& kind) {
  const std::vector<const ReportRow*> rows = data.rows(kind);
  bool is_first = true;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i]->json->contains("verdicts")) continue;
    if (is_first) table.begin_group(rays_of_kind(kind));
    is_first = false;
    std::vector<HtmlCell> ours = verdict_cells(data, *rows[i], "verdicts", rows[i]->label);
    ours.push_back(data.cell(rows[i]->pointer("unjudged"), [](double n) { return n > 0 ? count_text(n) : std::string(); }));
    ours.push_back(data.wrong_cell(*rows[i]));
    table.add_row(std::move(ours));
    if (!rows[i]->json->contains("embree_verdicts") || next_has_same_witness(rows, i)) continue;
    std::vector<HtmlCell> witness = verdict_cells(data, *rows[i], "embree_verdicts", "Embree robust");
    witness.push_back(words(""));
    witness.push_back(witness_rate_cell(*rows[i]));
    table.add_row(std::move(witness), "reference");
  }
}

}  // namespace

std::string summary_table(const ReportData& data) {
  HtmlTable table(
      "<b>The fastest method of each kind of rays that has no wrong hit,</b> beside Embree on the same rays in the same run.",
      {{"rays"},
       {"fastest method", true},
       {"ns a ray"},
       {"Mrays/s"},
       {"× Embree"},
       {"× best mode of Embree"},
       {"wrong per million"},
       {"Embree robust, wrong per million"},
       {"count of rays"}});
  for (const std::string& kind : data.kinds()) {
    const ReportRow* const row = data.fastest_clean(kind);
    if (row == nullptr) continue;
    table.add_row(
        {row_head(kind), words(row->label), data.ns_cell(*row), data.cell(row->pointer("mrays_per_second"), short_number),
         data.cell(row->pointer("ratio_to_embree"), hundredths), data.cell(row->pointer("ratio_to_best_embree"), hundredths),
         data.wrong_cell(*row), witness_rate_cell(*row), data.cell(row->pointer("rays"), count_text)});
  }
  return table.empty() ? "" : table.html();
}

std::string speed_table(const ReportData& data) {
  const HtmlTable table(
      "<b>Speed.</b> Medians of all runs, which methods took in turns; least and most beside them. ● marks the front: no other "
      "method is both faster and less often wrong.",
      {{"method", true},
       {"Mrays/s"},
       {"least"},
       {"most"},
       {"ns a ray"},
       {"instructions a ray"},
       {"× Embree"},
       {"× best mode"},
       {"wrong per million"},
       {"front"}});
  return by_kind(
      table, data, [](const ReportRow&) { return true; },
      [&](const ReportRow& row) {
        return std::vector<HtmlCell>{row_head(row.label),
                                     data.cell(row.pointer("mrays_per_second"), short_number),
                                     data.cell(row.pointer("mrays_min"), short_number),
                                     data.cell(row.pointer("mrays_max"), short_number),
                                     data.ns_cell(row),
                                     data.cell(row.pointer("instructions_per_ray"), count_text),
                                     data.cell(row.pointer("ratio_to_embree"), hundredths),
                                     data.cell(row.pointer("ratio_to_best_embree"), hundredths),
                                     data.wrong_cell(row),
                                     words(data.is_on_front(row) ? "●" : "")};
      });
}

std::string verdicts_table(const ReportData& data) {
  HtmlTable table(
      "<b>Verdicts.</b> Of the rays on which a method and the witness agree a sample is judged in exact arithmetic, of all "
      "others "
      "every one. <i>neighbour</i> and <i>edge</i> are answers within the proved bound of rounding; <i>miss</i>, <i>far</i> "
      "and "
      "<i>false</i> are wrong. Where none is wrong, the rate is below 3/N with 95 % confidence.",
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
  const HtmlTable table(
      "<b>Adjudication.</b> Who was right on the judged rays, and how far the t of right hits is from the exact one, in units "
      "in the "
      "last place.",
      {{"method", true},
       {"both right"},
       {"only ours"},
       {"only Embree"},
       {"neither"},
       {"t error, mean ulp"},
       {"p99"},
       {"most"},
       {"barycentric, most"}});
  return by_kind(table, data, with("verdicts"), [&](const ReportRow& row) {
    const auto count = [&](const char* key) { return data.cell(row.pointer(std::string("adjudication/") + key), count_text); };
    return std::vector<HtmlCell>{row_head(row.label),
                                 count("both_right"),
                                 count("only_ours_right"),
                                 count("only_embree_right"),
                                 count("both_wrong"),
                                 data.cell(row.pointer("t_ulp/mean"), hundredths),
                                 data.cell(row.pointer("t_ulp/p99"), hundredths),
                                 data.cell(row.pointer("t_ulp/max"), hundredths),
                                 data.cell(row.pointer("barycentric_error_max"), short_number)};
  });
}

std::string structures_table(const ReportData& data) {
  HtmlTable table("<b>Structures.</b> What each costs to build and to keep; expected cost by the surface area heuristic.",
                  {{"structure", true},
                   {"build"},
                   {"memory"},
                   {"bytes a triangle"},
                   {"triangles"},
                   {"references"},
                   {"SAH cost"},
                   {"depth"},
                   {"leaves"},
                   {"mean leaf"}});
  const Json& structures = data.context()["structures"];
  for (std::size_t i = 0; i < structures.size(); ++i) {
    const auto at = [&](const char* key) { return "/context/structures/" + std::to_string(i) + "/" + key; };
    const std::string name = structures[i].value("name", "");
    table.add_row(
        {row_head(name), data.cell(at("build_seconds"), seconds_number), data.cell(at("bytes"), bytes_number),
         data.ratio_cell(at("bytes"), "/context/triangles", short_number), data.cell(at("triangles"), count_text),
         data.cell(at("references"), count_text), data.cell(at("sah_cost"), short_number), data.cell(at("depth"), count_text),
         data.cell(at("leaves"), count_text), data.cell(at("leaf_size_mean"), short_number)},
        name.starts_with("Embree") ? "reference" : "");
  }
  return table.empty() ? "" : table.html();
}

std::string counters_table(const ReportData& data) {
  const HtmlTable table("<b>Steps a ray.</b> Counts do not depend on the machine.", {{"method", true},
                                                                                     {"nodes"},
                                                                                     {"box tests"},
                                                                                     {"triangle tests"},
                                                                                     {"leaves"},
                                                                                     {"backtracks"},
                                                                                     {"bytes"},
                                                                                     {"instructions"}});
  return by_kind(table, data, with("nodes_per_ray"), [&](const ReportRow& row) {
    std::vector<HtmlCell> cells = {row_head(row.label)};
    for (const char* key : {"nodes_per_ray", "box_tests_per_ray", "triangle_tests_per_ray", "leaves_per_ray",
                            "backtracks_per_ray", "bytes_per_ray", "instructions_per_ray"})
      cells.push_back(data.cell(row.pointer(key), short_number));
    return cells;
  });
}

std::string simt_table(const ReportData& data) {
  const HtmlTable table(
      "<b>In warps of 32 lanes.</b> The share of lanes at work by phase, and the bytes that they ask for a ray.",
      {{"method", true},
       {"all"},
       {"descend"},
       {"intersect"},
       {"backtrack"},
       {"nodes, bytes"},
       {"triangles"},
       {"stack"},
       {"hash"},
       {"ray"}});
  return by_kind(table, data, with("simt"), [&](const ReportRow& row) {
    std::vector<HtmlCell> cells = {row_head(row.label), data.cell(row.pointer("simt/efficiency"), percent_text)};
    for (const char* phase : {"descend", "intersect", "backtrack"})
      cells.push_back(data.cell(row.pointer(std::string("simt/") + phase + "/efficiency"), percent_text));
    for (const char* of : {"node", "triangle", "stack", "hash", "ray"})
      cells.push_back(
          data.ratio_cell(row.pointer(std::string("simt/traffic/") + of + "/bytes"), row.pointer("rays"), short_number));
    return cells;
  });
}

std::string multipass_table(const ReportData& data) {
  const HtmlTable table(
      "<b>As streams through small kernels.</b> Passes, lanes at work, and what is carried between passes, a ray.",
      {{"method", true},
       {"rule", true},
       {"passes"},
       {"switches"},
       {"lanes at work"},
       {"in warps"},
       {"transitions a ray"},
       {"bytes recirculated"},
       {"bytes fetched"}});
  return by_kind(table, data, with("multipass"), [&](const ReportRow& row) {
    const auto at = [&](const char* key) { return row.pointer(std::string("multipass/") + key); };
    const auto a_ray = [&](const char* key) { return data.ratio_cell(at(key), row.pointer("rays"), short_number); };
    return std::vector<HtmlCell>{row_head(row.label),
                                 words((*row.json)["multipass"].value("rule", "")),
                                 data.cell(at("passes"), count_text),
                                 data.cell(at("switches"), count_text),
                                 data.cell(at("utilisation"), percent_text),
                                 data.cell(at("warp_utilisation"), percent_text),
                                 a_ray("transitions"),
                                 a_ray("bytes_recirculated"),
                                 a_ray("bytes_fetched")};
  });
}

std::string sort_table(const ReportData& data) {
  HtmlTable table("<b>Sorted rays.</b> What sorting costs for all rays, and the speed without and with that cost.",
                  {{"rays"},
                   {"method", true},
                   {"sort", true},
                   {"chunks"},
                   {"hash"},
                   {"sort"},
                   {"copy"},
                   {"Mrays/s as they came"},
                   {"sorted"},
                   {"sorted, in all"},
                   {"answers that differ"}});
  const auto milliseconds = [](double ms) { return seconds_text(1e-3 * ms); };
  for (const ReportRow& row : data.sorts()) {
    const auto speed = [&](const char* key) { return data.cell(row.pointer(key), short_number); };
    table.add_row({row_head(row.rays_kind), words(row.method), words(row.json->value("sort", "")),
                   data.cell(row.pointer("chunks"), count_text), data.cell(row.pointer("hash_ms"), milliseconds),
                   data.cell(row.pointer("sort_ms"), milliseconds), data.cell(row.pointer("copy_ms"), milliseconds),
                   speed("mrays_as_they_came"), speed("mrays_without_sort_cost"), speed("mrays_per_second"),
                   failures_cell(data, row.pointer("different_answers"))});
  }
  return table.empty() ? "" : table.html();
}

}  // namespace accel::apps
