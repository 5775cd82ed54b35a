#include "apps/common/report_tables.h"

#include "apps/common/text.h"

namespace accel::apps {

namespace {

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

}  // namespace

std::string summary_table(const ReportData& data) {
  const bool was_checked = data.any_row_has("error") || data.any_row_has("wrong_per_million");
  HtmlTable table(was_checked ? "<b>The fastest method of each kind of rays that has no wrong hit,</b> beside Embree on the "
                                "same rays in the same run."
                              : "<b>The fastest method of each kind of rays,</b> beside Embree on the same rays in the same "
                                "run. Hits were not checked.",
                  {{"rays", true},
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
         data.wrong_cell(*row), data.witness_wrong_cell(*row), data.cell(row->pointer("rays"), count_text)});
  }
  return table.empty() ? "" : table.html();
}

std::string speed_table(const ReportData& data) {
  const HtmlTable table(
      "<b>Speed in numbers.</b> Medians of all runs, which methods took in turns; least and most beside them. ● marks the "
      "front: no other method is both faster and less often wrong." +
          errors_note(data),
      {{"method", true},
       {"Mrays/s"},
       {"least"},
       {"most"},
       {"ns a ray"},
       {"instructions a ray"},
       {"× Embree"},
       {"× best mode"},
       {"wrong per million"},
       {"leaks per million"},
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
                                     data.rate_cell(row.pointer("leaks/per_million"), row.pointer("leaks/bound95_per_million")),
                                     HtmlCell{data.is_on_front(row) ? "●" : "", HtmlCell::Kind::number}};
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

std::string scaling_table(const ReportData& data) {
  HtmlTable table("<b>Scaling in numbers.</b>",
                  {{"method", true}, {"triangles"}, {"ns a ray"}, {"build"}, {"memory"}, {"bytes a triangle"}});
  if (!data.json().contains("scaling")) return "";
  const Json& points = data.json()["scaling"];
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto at = [&](const char* key) { return "/scaling/" + std::to_string(i) + "/" + key; };
    table.add_row({row_head(points[i].value("method", "")), data.cell(at("triangles"), count_text),
                   data.cell(at("ns_per_ray"), short_number), data.cell(at("build_seconds"), seconds_number),
                   data.cell(at("bytes"), bytes_number), data.ratio_cell(at("bytes"), at("triangles"), short_number)},
                  points[i].value("method", "").starts_with("Embree") ? "reference" : "");
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
                  {{"rays", true},
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
                   data.failures_cell(row.pointer("different_answers"))});
  }
  return table.empty() ? "" : table.html();
}

}  // namespace accel::apps
