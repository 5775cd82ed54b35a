#include "apps/common/report_html.h"

#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>

#include "apps/common/program_files.h"
#include "apps/common/report_data.h"
#include "apps/common/report_headline.h"
#include "apps/common/report_parts.h"
#include "apps/common/report_plots.h"
#include "apps/common/report_tables.h"

namespace accel::apps {

namespace {

// The template with each {{name}} replaced; what is put in is not looked at again.
std::string filled(std::string_view text, std::initializer_list<std::pair<std::string_view, std::string_view>> values) {
  std::string result;
  while (true) {
    const std::size_t begin = text.find("{{"), end = text.find("}}", begin);
    if (begin == text.npos || end == text.npos) return result.append(text);
    result.append(text.substr(0, begin));
    const std::string_view name = text.substr(begin + 2, end - begin - 2);
    for (const auto& [known, value] : values)
      if (known == name) result.append(value);
    text.remove_prefix(end + 2);
  }
}

// Empty where it was not built or is no longer there.
std::string plots_library() {
  const std::filesystem::path path = find_program_file(ACCEL_REPORT_PLOTS_FOLDER, ACCEL_REPORT_PLOTS_FILE);
  if (path.empty()) return {};
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A part of the page; nothing where the run has nothing for it.
std::string section(const std::string& title, std::initializer_list<std::string> parts) {
  std::string content;
  for (const std::string& part : parts) content += part;
  return content.empty() ? "" : "<section>\n<h2>" + title + "</h2>\n" + content + "</section>\n";
}

std::string subject_html(const ReportData& data) {
  return "<p class=\"subject\">" + html_escaped(count_text(data.number("/context/triangles").value_or(0))) +
         " triangles · ray-tracing acceleration structures by libaccel · " +
         html_escaped(data.context_text("date").substr(0, 10)) + "</p>\n";
}

// "what: why" for each; folded up where there are many.
std::string list_html(const Json& items, const char* why, const std::string& title) {
  std::string html;
  for (const Json& item : items)
    html += "<li>" + html_escaped(item.value("what", "")) + ": " + html_escaped(item.value(why, "")) + "</li>\n";
  if (html.empty()) return "";
  const std::string list = "<ul class=\"plain\">\n" + html + "</ul>\n";
  if (items.size() <= 8) return "<h3>" + title + "</h3>\n" + list;
  return "<details><summary>" + title + ": " + std::to_string(items.size()) + "</summary>\n" + list + "</details>\n";
}

std::string reproduce_html(const ReportData& data) {
  return "<pre><code>" + html_escaped(data.context_text("command_line")) + "</code></pre>\n" +
         "<p class=\"note\">Rays depend on the seed alone, and hits on nothing else; times depend on the machine. The page "
         "carries all "
         "numbers as JSON in Google Benchmark's shape, in its element <code>numbers</code>.</p>\n";
}

// What stands where no plot shows.
std::string why_no_plots(bool has_library) {
  if (has_library) return "Plots need scripts, which are off here.";
  if (!report_plots_version().starts_with("Vega")) return "Plots were left out: this program was built without Vega-Lite.";
  return "Plots were left out: " ACCEL_REPORT_PLOTS_FILE " is neither next to the program nor where it was installed.";
}

std::string content_html(const ReportData& data, std::span<const MethodPictures> pictures, bool has_plots) {
  const std::string no_plots =
      "<p class=\"note without-plots\">" + why_no_plots(has_plots) + " The tables have all numbers.</p>\n";
  return "<header>\n<h1>" + html_escaped(scene_title(data)) + "</h1>\n" + subject_html(data) + alarm_html(data) +
         finding_html(data) + "</header>\n" + summary_table(data) + facts_html(data) + no_plots +
         section("Speed and error",
                 {figure_html(pareto_plot(data)), figure_html(speed_plot(data)), speed_table(data), sort_table(data)}) +
         section("Correctness", {verdicts_table(data), adjudication_table(data)}) +
         section("Where the time goes",
                 {pictures_html(pictures), counters_table(data), simt_table(data), multipass_table(data)}) +
         section("Structures",
                 {structures_table(data), figure_html(leaf_sizes_plot(data)), figure_html(leaf_depths_plot(data))}) +
         section("Scaling", {figure_html(scaling_plot(data)), scaling_table(data)}) +
         section("Left out, and why", {list_html(data.context()["skipped"], "because", "Skipped"),
                                       list_html(data.context()["notes"], "why", "Notes of the builds")}) +
         section("To reproduce", {reproduce_html(data)});
}

}  // namespace

std::string report_html(const std::string& json, std::span<const MethodPictures> pictures) {
  const ReportData data(json);
  const std::string library = plots_library();
  const std::string title = html_escaped(scene_title(data)) + " · accel-trace";
  const std::string content = content_html(data, pictures, !library.empty());
  const std::string numbers = json_in_script(json);
  const std::string library_element = library.empty() ? "" : "<script>\n" + library + "</script>\n";
  return filled(report_parts::page, {{"title", title},
                                     {"style", report_parts::style},
                                     {"content", content},
                                     {"numbers", numbers},
                                     {"plots_library", library_element},
                                     {"script", report_parts::script}});
}

std::string report_plots_version() { return ACCEL_REPORT_PLOTS_VERSION; }

}  // namespace accel::apps
