// The JSON of a run as its page reads it: rows by kind of rays, and cells that show one of its numbers and say which.
//
// Cells carry where their number comes from, as a JSON pointer: data-json="/benchmarks/0/rays". The number that they show is
// that one; divided by another, data-over="POINTER"; or, with data-inverse="K", it is K over the number. Tests hold every cell
// against the JSON in the page.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/html.h"

namespace accel::apps {

using Json = nlohmann::ordered_json;

// One of "benchmarks": a method, or Embree in one of its modes, on a kind of rays.
struct ReportRow {
  std::size_t index = 0;
  const Json* json = nullptr;
  std::string method, test, rays_kind;
  std::string label;  // the method, with the triangle test where that is not the first: "sbvh/stack + woop"
  bool is_embree = false, is_sort = false;
  bool is_promised = true;             // wrong hits are failures: not of what a sweep has for comparison
  double ns = 0;                       // a ray; 0: not timed
  std::optional<double> wrong, bound;  // hits per million, and the 95 % bound of their rate; not where nothing is checked

  // Where these come from: the rate on these rays, or in sweeps the higher one of these and of edge rays.
  std::string wrong_path, bound_path;

  std::string pointer(const std::string& path) const { return "/benchmarks/" + std::to_string(index) + "/" + path; }
  bool is_clean() const { return wrong && *wrong == 0; }
};

class ReportData {
 public:
  using Format = std::string (*)(double);

  // `json` is what report_json() returns.
  explicit ReportData(const std::string& json);
  ReportData(const ReportData&) = delete;
  ReportData& operator=(const ReportData&) = delete;

  const Json& json() const { return json_; }
  const Json& context() const { return json_["context"]; }
  std::string context_text(const std::string& key) const;

  const std::vector<std::string>& kinds() const { return kinds_; }
  std::vector<const ReportRow*> rows(const std::string& kind) const;  // Embree's come last
  const std::vector<ReportRow>& sorts() const { return sorts_; }
  bool any_row_has(const std::string& key) const;
  bool have_tests() const { return have_tests_; }

  // The row of Embree that ratios refer to, or null.
  const ReportRow* embree(const std::string& kind) const;
  // The fastest of our rows without a wrong hit, of those that are checked; of all where nothing is checked. Null without rows.
  const ReportRow* fastest_clean(const std::string& kind) const;
  // Whether none of our rows on the same rays is both faster and less often wrong: as the JSON says, or found out here. Rows
  // that are not checked are on no front.
  bool is_on_front(const ReportRow& row) const;
  // Wrong hits per million of Embree ROBUST on the same rays as a row, and the 95 % bound; nothing without a witness.
  struct Wrong {
    double rate = 0, bound = 0;
  };
  static std::optional<Wrong> witness_wrong(const ReportRow& row);

  // A number of the JSON; nothing where there is none.
  std::optional<double> number(const std::string& pointer) const;
  // Cells of numbers; empty where there is none.
  HtmlCell cell(const std::string& pointer, Format format) const;
  HtmlCell ratio_cell(const std::string& pointer, const std::string& over, Format format) const;
  HtmlCell inverse_cell(const std::string& pointer, double numerator, Format format) const;
  HtmlCell ns_cell(const ReportRow& row) const;
  // A rate per million, or where it is 0 its bound: "< 61.0"; a dash where no ray was decided.
  HtmlCell rate_cell(const std::string& pointer, const std::string& bound_pointer) const;
  HtmlCell wrong_cell(const ReportRow& row) const;
  HtmlCell witness_wrong_cell(const ReportRow& row) const;
  // A count that should be 0.
  HtmlCell failures_cell(const std::string& pointer) const;

 private:
  ReportRow row_of(std::size_t index) const;

  Json json_;
  std::vector<std::string> kinds_;
  std::vector<ReportRow> rows_, sorts_;
  bool have_tests_ = false;
};

// "primary rays", or a file's name.
std::string rays_of_kind(const std::string& kind);

// What errors are where rows have them in a sweep; empty otherwise.
std::string errors_note(const ReportData& data);

HtmlCell words(std::string text);
HtmlCell row_head(std::string text);

// Formats of numbers.
std::string count_text(double value);
std::string bytes_number(double value);
std::string seconds_number(double value);
std::string percent_text(double share);
std::string hundredths(double value);

}  // namespace accel::apps
