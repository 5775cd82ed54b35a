#include "apps/common/report_data.h"

#include <algorithm>
#include <cmath>

#include "apps/common/text.h"

namespace accel::apps {

namespace {

std::string text_of(const Json& json, const std::string& key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : "";
}

double number_of(const Json& json, const std::string& key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? found->get<double>() : 0;
}

}  // namespace

ReportData::ReportData(const std::string& json) : json_(Json::parse(json)) {
  for (std::size_t i = 0; i < json_["benchmarks"].size(); ++i) {
    ReportRow row = row_of(i);
    if (std::find(kinds_.begin(), kinds_.end(), row.rays_kind) == kinds_.end()) kinds_.push_back(row.rays_kind);
    (row.is_sort ? sorts_ : rows_).push_back(std::move(row));
  }
  const auto differs = [&](const ReportRow& row) { return !row.is_embree && row.test != rows_.front().test; };
  have_tests_ = std::any_of(rows_.begin(), rows_.end(), differs);
}

ReportRow ReportData::row_of(std::size_t index) const {
  const Json& json = json_["benchmarks"][index];
  ReportRow row;
  row.index = index, row.json = &json;
  row.method = text_of(json, "method"), row.test = text_of(json, "test"), row.rays_kind = text_of(json, "rays_kind");
  const bool is_first_test = row.test.empty() || !text_of(json, "name").ends_with("/" + row.test);
  row.label = is_first_test ? row.method : row.method + " + " + row.test;
  row.is_promised = json.value("promised", true);
  row.is_embree = row.method == "Embree" || row.method.starts_with("Embree/");
  row.is_sort = json.contains("sort");
  const double mrays = number_of(json, "mrays_per_second");
  row.ns = json.contains("ns_per_ray") ? number_of(json, "ns_per_ray") : mrays > 0 ? 1e3 / mrays : 0;
  const bool in_sweep = json.contains("error");
  row.wrong_path = in_sweep ? "error/per_million" : "wrong_per_million";
  row.bound_path = in_sweep ? "error/bound95_per_million" : "wrong_per_million_bound95";
  row.wrong = number(row.pointer(row.wrong_path)), row.bound = number(row.pointer(row.bound_path));
  return row;
}

std::string ReportData::context_text(const std::string& key) const { return text_of(context(), key); }

std::vector<const ReportRow*> ReportData::rows(const std::string& kind) const {
  std::vector<const ReportRow*> found;
  for (const ReportRow& row : rows_)
    if (row.rays_kind == kind) found.push_back(&row);
  return found;
}

bool ReportData::any_row_has(const std::string& key) const {
  return std::any_of(rows_.begin(), rows_.end(), [&](const ReportRow& row) { return row.json->contains(key); });
}

const ReportRow* ReportData::embree(const std::string& kind) const {
  for (const ReportRow* row : rows(kind))
    if (row->method == "Embree") return row;
  return nullptr;
}

const ReportRow* ReportData::fastest_clean(const std::string& kind) const {
  const ReportRow* fastest = nullptr;
  for (const ReportRow* row : rows(kind)) {
    if (row->is_embree || (row->wrong && *row->wrong > 0)) continue;
    const bool is_faster = fastest == nullptr || (row->ns > 0 && row->ns < fastest->ns);
    if (is_faster) fastest = row;
  }
  return fastest;
}

bool ReportData::is_on_front(const ReportRow& row) const {
  if (row.json->contains("pareto")) return (*row.json)["pareto"] == true;
  if (row.is_embree || !row.wrong || !(row.ns > 0)) return false;
  const auto dominates = [&](const ReportRow* other) {
    if (other->is_embree || !other->wrong || !(other->ns > 0)) return false;
    const bool is_no_worse = other->ns <= row.ns && *other->wrong <= *row.wrong;
    return is_no_worse && (other->ns < row.ns || *other->wrong < *row.wrong);
  };
  const auto rivals = rows(row.rays_kind);
  return std::none_of(rivals.begin(), rivals.end(), dominates);
}

std::optional<ReportData::Wrong> ReportData::witness_wrong(const ReportRow& row) {
  const Json rate = row.json->value("embree_wrong_per_million", Json());
  if (!rate.is_number()) return std::nullopt;
  return Wrong{rate.get<double>(), number_of(*row.json, "embree_wrong_per_million_bound95")};
}

std::optional<double> ReportData::number(const std::string& pointer) const {
  const Json::json_pointer path(pointer);
  if (!json_.contains(path) || !json_.at(path).is_number()) return std::nullopt;
  return json_.at(path).get<double>();
}

HtmlCell ReportData::cell(const std::string& pointer, Format format) const {
  const auto value = number(pointer);
  if (!value) return {"", HtmlCell::Kind::number};
  return {format(*value), HtmlCell::Kind::number, " data-json=\"" + pointer + "\""};
}

HtmlCell ReportData::ratio_cell(const std::string& pointer, const std::string& over, Format format) const {
  const auto value = number(pointer), divisor = number(over);
  if (!value || !divisor || !(*divisor > 0)) return {"", HtmlCell::Kind::number};
  return {format(*value / *divisor), HtmlCell::Kind::number, " data-json=\"" + pointer + "\" data-over=\"" + over + "\""};
}

HtmlCell ReportData::inverse_cell(const std::string& pointer, double numerator, Format format) const {
  const auto value = number(pointer);
  if (!value || !(*value > 0)) return {"", HtmlCell::Kind::number};
  return {format(numerator / *value), HtmlCell::Kind::number,
          " data-json=\"" + pointer + "\" data-inverse=\"" + print("%.17g", numerator) + "\""};
}

HtmlCell ReportData::ns_cell(const ReportRow& row) const {
  if (row.json->contains("ns_per_ray")) return cell(row.pointer("ns_per_ray"), short_number);
  return inverse_cell(row.pointer("mrays_per_second"), 1e3, short_number);
}

HtmlCell ReportData::rate_cell(const std::string& pointer, const std::string& bound_pointer) const {
  const auto rate = number(pointer);
  if (!rate) return {json_.contains(Json::json_pointer(pointer)) ? "\u2013" : "", HtmlCell::Kind::number};
  HtmlCell shown = cell(*rate > 0 ? pointer : bound_pointer, short_number);
  if (*rate > 0)
    shown.style = "bad";
  else
    shown.text = "< " + shown.text;
  return shown;
}

HtmlCell ReportData::wrong_cell(const ReportRow& row) const {
  return rate_cell(row.pointer(row.wrong_path), row.pointer(row.bound_path));
}

HtmlCell ReportData::witness_wrong_cell(const ReportRow& row) const {
  return rate_cell(row.pointer("embree_wrong_per_million"), row.pointer("embree_wrong_per_million_bound95"));
}

HtmlCell ReportData::failures_cell(const std::string& pointer) const {
  HtmlCell shown = cell(pointer, count_text);
  if (number(pointer).value_or(0) > 0) shown.style = "bad";
  return shown;
}

std::string rays_of_kind(const std::string& kind) { return kind.ends_with(".npy") ? kind : kind + " rays"; }

std::string errors_note(const ReportData& data) {
  return data.any_row_has("error") ? " Errors are the higher of those on these rays and on edge rays." : "";
}

HtmlCell words(std::string text) { return {std::move(text), HtmlCell::Kind::words}; }

HtmlCell row_head(std::string text) { return {std::move(text), HtmlCell::Kind::row_head}; }

std::string count_text(double value) { return with_commas(static_cast<std::uint64_t>(std::llround(value))); }

std::string bytes_number(double value) { return bytes_text(static_cast<std::uint64_t>(std::llround(value))); }

std::string seconds_number(double value) { return seconds_text(value); }

std::string percent_text(double share) { return print("%.1f %%", 100 * share); }

std::string hundredths(double value) { return value < 100 ? print("%.2f", value) : short_number(value); }

}  // namespace accel::apps
