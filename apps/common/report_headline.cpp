#include "apps/common/report_headline.h"

#include <algorithm>
#include <cctype>

#include "apps/common/text.h"
#include "libaccel/rays/ray_sets.h"

namespace accel::apps {

namespace {

std::string number_text(const ReportData& data, const std::string& pointer, ReportData::Format format) {
  return format(data.number(pointer).value_or(0));
}

std::string bold(const std::string& text) { return "<b>" + html_escaped(text) + "</b>"; }

std::string rays_of(const std::string& kind) { return html_escaped(rays_of_kind(kind)); }

// "bvh8/ordered is the fastest of 18 methods without a wrong hit".
std::string fastest_text(const ReportData& data, const ReportRow& best) {
  const auto rows = data.rows(best.rays_kind);
  const bool checked = best.wrong.has_value();
  const auto count = std::count_if(rows.begin(), rows.end(),
                                   [&](const ReportRow* row) { return !row->is_embree && (!checked || row->is_clean()); });
  if (count == 1) return bold(best.label) + " traces them" + (checked ? " without a wrong hit" : "");
  return bold(best.label) + " is the fastest of " + std::to_string(count) + " methods" +
         (checked ? " without a wrong hit" : "");
}

std::string speed_text(const ReportData& data, const ReportRow& best) {
  if (!(best.ns > 0)) return "";
  std::string text = ": " + short_number(best.ns) + " ns a ray";
  const auto ratio = data.number(best.pointer("ratio_to_embree"));
  if (ratio) text += ", " + print("%.2f", *ratio) + " times the speed of Embree";
  const auto best_ratio = data.number(best.pointer("ratio_to_best_embree"));
  if (best_ratio)
    text += " and " + print("%.2f", *best_ratio) + " times that of its fastest mode (" +
            html_escaped(best.json->value("best_embree_mode", "")) + ")";
  return text;
}

std::string wrong_text(double rate, double bound) {
  return rate > 0 ? short_number(rate) + " in a million are wrong"
                  : "none is wrong (below " + short_number(bound) + " in a million with 95 % confidence)";
}

std::string errors_text(const ReportRow& best) {
  if (!best.wrong) return " Its hits were not checked.";
  std::string text = " Of its hits " + wrong_text(*best.wrong, best.bound.value_or(0));
  if (const auto witness = ReportData::witness_wrong(best))
    text += "; of Embree's, in its robust mode, " +
            (witness->rate > 0 || *best.wrong > 0 ? wrong_text(witness->rate, witness->bound) : std::string("none either"));
  return text + ".";
}

// The kind of rays on which the witness errs most, if that is not the first one.
std::string witness_text(const ReportData& data) {
  const ReportRow* worst = nullptr;
  double most = 0;
  for (std::size_t k = 1; k < data.kinds().size(); ++k)
    if (const ReportRow* const best = data.fastest_clean(data.kinds()[k]))
      if (const auto witness = ReportData::witness_wrong(*best); witness && witness->rate > most)
        most = witness->rate, worst = best;
  if (worst == nullptr) return "";
  return " On " + rays_of(worst->rays_kind) + " Embree's robust mode has " + short_number(most) +
         " wrong hits in a million, and " + bold(worst->label) + " has none (below " + short_number(worst->bound.value_or(0)) +
         ").";
}

// Ours with wrong hits, those with the most first.
std::vector<const ReportRow*> wrong_rows(const ReportData& data) {
  std::vector<const ReportRow*> found;
  for (const std::string& kind : data.kinds())
    for (const ReportRow* row : data.rows(kind))
      if (!row->is_embree && row->is_promised && row->wrong.value_or(0) > 0) found.push_back(row);
  std::stable_sort(found.begin(), found.end(), [](const ReportRow* a, const ReportRow* b) { return *a->wrong > *b->wrong; });
  return found;
}

std::string wrong_item(const ReportData& data, const ReportRow& row) {
  const auto count = [&](const char* path) { return number_text(data, row.pointer(path), count_text); };
  return "<li>" + html_escaped(row.label) + ", " + rays_of(row.rays_kind) + ": " + short_number(*row.wrong) +
         " per million (miss " + count("verdicts/miss") + ", far " + count("verdicts/far") + ", false " +
         count("verdicts/false") + " of " + count("rays") + " rays)</li>\n";
}

// What a sweep recommends, by kind of rays.
std::string advice_html(const ReportData& data) {
  std::string html;
  const auto advice = data.context().find("advice");
  if (advice == data.context().end() || !advice->is_object()) return html;
  for (std::string text : *advice) {
    if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
    html += "<p class=\"finding\">" + html_escaped(text) + ".</p>\n";
  }
  return html;
}

std::string fact(const std::string& name, const std::string& value) {
  return value.empty() ? "" : "<div><dt>" + html_escaped(name) + "</dt><dd>" + html_escaped(value) + "</dd></div>\n";
}

std::string vector_text(const Json& v) {
  std::vector<std::string> parts;
  for (const Json& x : v) parts.push_back(short_number(x.get<double>()));
  return "(" + join(parts, " ") + ")";
}

std::string camera_text(const Json& camera) {
  const std::string name = camera.value("name", "");
  return (name.empty() ? "" : name + ", ") + "at " + vector_text(camera["eye"]) + " towards " + vector_text(camera["at"]) +
         ", vfov " + short_number(camera.value("vfov", 0.0)) + "°";
}

std::string rays_text(const ReportData& data) {
  std::vector<std::string> parts;
  for (const std::string& kind : data.kinds())
    for (const ReportRow* row : data.rows(kind)) {
      parts.push_back(kind + " " + number_text(data, row->pointer("rays"), count_text));
      break;
    }
  return join(parts, ", ");
}

std::string machine_text(const ReportData& data) {
  const std::string device = data.context_text("device");
  return data.context_text("host_name") + ", " +
         counted(static_cast<std::uint64_t>(data.number("/context/num_cpus").value_or(0)), "processor") + ", " +
         counted(static_cast<std::uint64_t>(data.number("/context/threads").value_or(0)), "thread") +
         (device == "cpu" ? "" : ", methods on " + device);
}

std::string version(const ReportData& data, const char* of) { return data.context()["versions"].value(of, ""); }

}  // namespace

std::string scene_title(const ReportData& data) {
  const std::string scene = data.context_text("scene");
  return scene.substr(scene.find_last_of('/') + 1);
}

std::string alarm_html(const ReportData& data) {
  constexpr std::size_t kListed = 6;
  const std::vector<const ReportRow*> rows = wrong_rows(data);
  std::string items;
  for (std::size_t i = 0; i < std::min(rows.size(), kListed); ++i) items += wrong_item(data, *rows[i]);
  if (rows.size() > kListed) items += "<li>and " + std::to_string(rows.size() - kListed) + " more, in the tables below</li>\n";
  for (const ReportRow& row : data.sorts())
    if (const double different = data.number(row.pointer("different_answers")).value_or(0); different > 0)
      items += "<li>" + html_escaped(row.method) + ", " + rays_of(row.rays_kind) + ": " + count_text(different) +
               " answers changed when the rays were sorted</li>\n";
  return items.empty() ? ""
                       : "<div class=\"alarm\" role=\"alert\"><strong>Wrong hits</strong>\n<ul>\n" + items + "</ul></div>\n";
}

std::string finding_html(const ReportData& data) {
  if (const std::string advice = advice_html(data); !advice.empty()) return advice;
  if (data.kinds().empty()) return "";
  const ReportRow* const best = data.fastest_clean(data.kinds().front());
  if (best == nullptr)
    return "<p class=\"finding\">No method is without wrong hits on " + rays_of(data.kinds().front()) + ".</p>\n";
  return "<p class=\"finding\">On " + rays_of(best->rays_kind) + ", " + fastest_text(data, *best) + speed_text(data, *best) +
         "." + errors_text(*best) + witness_text(data) + "</p>\n";
}

// Where the user has said what is asked, whatever the kind of rays.
std::string asked_of_all(const ReportData& data) {
  const std::string query = data.context_text("query");
  if (query.empty()) return {};
  return query == "any" ? "of all rays, whether they meet anything" : "of all rays, their closest hits";
}

std::string facts_html(const ReportData& data) {
  const auto number = [&](const char* key) { return data.number(std::string("/context/") + key).value_or(0); };
  const std::string test = data.context_text("triangle_test");
  return "<dl class=\"facts\">\n" + fact("Scene", data.context_text("scene")) +
         fact("Triangles", count_text(number("triangles")) + ", loaded in " + seconds_text(number("load_seconds"))) +
         fact("Rays", rays_text(data)) + fact("Query", asked_of_all(data)) +
         fact("Picture", print("%.0f × %.0f pixels%s, %.0f a pixel", number("width"), number("height"),
                               data.context_text("pixel_order") == order_name(PixelOrder::z_curve) ? " along a Z-curve" : "",
                               number("spp"))) +
         fact("Camera", camera_text(data.context()["camera"])) + fact("Triangle test", data.have_tests() ? "" : test) +
         fact("Timed runs", count_text(number("repeat")) + " of each method, in turns") +
         fact("Seed", with_commas(data.context().value("seed", std::uint64_t{0}))) + fact("Machine", machine_text(data)) +
         fact("Date", data.context_text("date")) +
         fact("libaccel",
              version(data, "libaccel") + ", " + data.context_text("library_build_type") + " by " + version(data, "compiler")) +
         fact("Witness", data.context_text("witness")) + fact("Check", data.context_text("check")) + "</dl>\n";
}

}  // namespace accel::apps
