#include "apps/common/report_plots.h"

#include <algorithm>
#include <cmath>

#include "apps/common/report_parts.h"
#include "apps/common/text.h"

namespace accel::apps {

namespace {

// Okabe and Ito's colours for all kinds of eyes, without black and yellow, which do not show on both light and dark paper.
constexpr const char* kMethodColors[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                         "#e69f00", "#56b4e9", "#8c6d31", "#7570b3"};
constexpr const char* kShapes[] = {"circle", "square", "triangle-up", "diamond", "cross", "triangle-down", "triangle-right"};

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

// Distinct values of a field of rows, in order.
std::vector<std::string> distinct(const Json& rows, const char* field) {
  std::vector<std::string> found;
  for (const Json& row : rows)
    if (const std::string value = row.value(field, ""); std::find(found.begin(), found.end(), value) == found.end())
      found.push_back(value);
  return found;
}

// Labels of Embree's modes stand above the data in as few lanes as keep them apart.
class Lanes {
 public:
  static constexpr double kHeight = 12, kFirst = 8;

  // The panel shows from `least` to `most` ns on a logarithmic scale, of which a character takes about this share.
  Lanes(double least, double most) : least_(least), span_(std::max(std::log(most / least), 1e-9)) {}

  // Adds where a mode's label stands to its row.
  void place(Json& row) {
    const double at = std::log(row["ns"].get<double>() / least_) / span_;
    const double width = 0.024 * static_cast<double>(row["label"].get<std::string>().size() + 2);
    const bool on_left = at > 0.6;
    const double from = on_left ? at - width : at - 0.01, to = on_left ? at + 0.01 : at + width;
    std::size_t lane = 0;
    while (lane < lanes_.size() && !lanes_[lane].is_free(from, to)) ++lane;
    if (lane == lanes_.size()) lanes_.emplace_back();
    lanes_[lane].taken.emplace_back(from, to);
    row["lane_y"] = kFirst + kHeight * static_cast<double>(lane);
    row["on_left"] = on_left;
  }

  double height() const { return lanes_.empty() ? 0 : kFirst + kHeight * static_cast<double>(lanes_.size()); }

 private:
  struct Lane {
    std::vector<std::pair<double, double>> taken;
    bool is_free(double from, double to) const {
      return std::none_of(taken.begin(), taken.end(), [&](const auto& t) { return from < t.second && t.first < to; });
    }
  };

  double least_, span_;
  std::vector<Lane> lanes_;
};

Json mark_of(const ReportData& data, const ReportRow& row) {
  return {{"rays", row.rays_kind},
          {"label", row.label},
          {"method", row.method},
          {"test", row.test},
          {"ns", row.ns},
          {"wrong", or_null(row.wrong)},
          {"bound", or_null(row.bound)},
          {"role", "ours"},
          {"front", data.is_on_front(row)}};
}

// Embree's rows are not judged by themselves, but its ROBUST mode is the witness, whose errors are known.
Json reference_of(const ReportRow& row, const ReportRow* judged) {
  std::optional<double> wrong = row.wrong, bound = row.bound;
  const auto witness = judged == nullptr ? std::nullopt : ReportData::witness_wrong(*judged);
  if (!wrong && row.method == "Embree/robust" && witness) wrong = witness->rate, bound = witness->bound;
  return {{"rays", row.rays_kind},   {"label", row.method},     {"method", row.method}, {"ns", row.ns},
          {"wrong", or_null(wrong)}, {"bound", or_null(bound)}, {"role", "embree"},     {"front", false}};
}

// The marks of a kind of rays; returns the height that its labels take.
double add_marks(Json& marks, const ReportData& data, const std::string& kind) {
  const auto rows = data.rows(kind);
  double least = INFINITY, most = 0;
  for (const ReportRow* row : rows)
    if (row->ns > 0) least = std::min(least, row->ns), most = std::max(most, row->ns);
  Lanes lanes(least, most);
  const ReportRow* const judged = data.fastest_clean(kind);
  for (const ReportRow* row : rows) {
    if (!(row->ns > 0)) continue;
    Json mark = row->is_embree ? reference_of(*row, judged) : mark_of(data, *row);
    if (row->is_embree) lanes.place(mark);
    if (row->is_embree || row->wrong) marks.push_back(std::move(mark));
  }
  return lanes.height();
}

void set_parameter(Json& spec, const std::string& name, Json value) {
  for (Json& parameter : spec["params"])
    if (parameter["name"] == name) parameter["value"] = std::move(value);
}

// A scale that is linear near 0 and logarithmic above the smallest number that it shows.
void set_error_scale(Json& spec, const Json& marks) {
  double least = INFINITY, most = 0;
  for (const Json& mark : marks)
    for (const char* key : {"wrong", "bound"})
      if (mark[key].is_number() && mark[key].get<double>() > 0)
        least = std::min(least, mark[key].get<double>()), most = std::max(most, mark[key].get<double>());
  if (!(most > 0)) least = most = 1;
  const double linear_below = std::pow(10, std::floor(std::log10(least)));
  Json ticks = {0.0};
  for (double tick = linear_below; tick <= most * 2; tick *= 10) ticks.push_back(tick);
  set_parameter(spec, "linear_below", linear_below);
  set_parameter(spec, "lowest", -0.9 * linear_below);
  set_parameter(spec, "highest", most * 1.5);
  set_parameter(spec, "ticks", ticks);
}

// Colours tell methods apart; where there are more of them than colours, so do shapes, unless these tell tests apart.
void set_method_scales(Json& spec, const ReportData& data, const Json& marks) {
  std::vector<std::string> methods, tests;
  for (const Json& mark : marks) {
    if (mark["role"] != "ours") continue;
    for (const auto& [list, field] : {std::pair{&methods, "method"}, {&tests, "test"}})
      if (const std::string value = mark[field]; std::find(list->begin(), list->end(), value) == list->end())
        list->push_back(value);
  }
  Json colors = Json::array(), shapes = Json::array();
  for (std::size_t m = 0; m < methods.size(); ++m) {
    colors.push_back(kMethodColors[m % std::size(kMethodColors)]);
    shapes.push_back(kShapes[m / std::size(kMethodColors) % std::size(kShapes)]);
  }
  Json& encoding = spec["spec"]["layer"][0]["encoding"];
  encoding["color"]["scale"] = {{"domain", methods}, {"range", colors}};
  if (!data.have_tests()) {
    encoding["shape"]["scale"] = {{"domain", methods}, {"range", shapes}};
    return;
  }
  encoding["shape"]["field"] = "test";
  encoding["shape"]["scale"] = {{"domain", tests}};
}

const char* state_of(const ReportRow& row) {
  if (row.is_embree) return "Embree";
  if (!row.wrong) return "not checked";
  return *row.wrong > 0 ? "wrong hits" : "no wrong hit";
}

Json bar_of(const ReportData& data, const ReportRow& row, const ReportRow* embree) {
  const auto number = [&](const char* key) { return data.number(row.pointer(key)); };
  const auto ratio = number("ratio_to_embree");
  return {{"rays", row.rays_kind},
          {"label", row.label},
          {"mrays", or_null(number("mrays_per_second"))},
          {"least", or_null(number("mrays_min"))},
          {"most", or_null(number("mrays_max"))},
          {"ratio", or_null(ratio)},
          {"ratio_text", ratio ? print("%.2f×", *ratio) : ""},
          {"is_reference", &row == embree},
          {"what", state_of(row)}};
}

// Ours before Embree, the fastest on the first kind of rays first.
Json bar_order(const ReportData& data) {
  std::vector<const ReportRow*> rows = data.rows(data.kinds().front());
  std::stable_sort(rows.begin(), rows.end(), [](const ReportRow* a, const ReportRow* b) {
    return std::pair(a->is_embree, a->ns) < std::pair(b->is_embree, b->ns);
  });
  Json labels = Json::array();
  for (const ReportRow* row : rows) labels.push_back(row->label);
  return labels;
}

// A histogram of each structure, of one of its keys, without the leaves that are beyond what 99.9 % reach: a few very long
// ones would leave no room for the others.
Json histogram_rows(const ReportData& data, const char* key) {
  constexpr double kShown = 0.999;
  Json rows = Json::array();
  for (const Json& structure : data.context()["structures"]) {
    if (!structure.contains(key)) continue;
    const Json& counts = structure[key];
    double all = 0, seen = 0;
    for (const Json& count : counts) all += count.get<double>();
    for (std::size_t n = 0; n < counts.size() && seen < kShown * all; ++n) {
      const double leaves = counts[n];
      seen += leaves;
      const double at = static_cast<double>(n);
      rows.push_back({{"structure", structure["name"]},
                      {"value", n},
                      {"from", at - 0.45},
                      {"to", at + 0.45},
                      {"leaves", leaves},
                      {"share", leaves / std::max(all, 1.0)}});
    }
  }
  return rows;
}

std::optional<ReportPlot> histogram_plot(const ReportData& data, const char* key, const std::string& what) {
  ReportPlot plot{key, {}, {}, Json::parse(report_parts::leaves)};
  plot.id = key == std::string("leaf_sizes") ? "plot-leaf-sizes" : "plot-leaf-depths";
  Json rows = histogram_rows(data, key);
  if (rows.empty()) return std::nullopt;
  plot.spec["facet"]["sort"] = distinct(rows, "structure");
  plot.spec["data"]["values"] = std::move(rows);
  plot.spec["spec"]["encoding"]["x"]["axis"]["title"] = what;
  plot.spec["spec"]["encoding"]["tooltip"][1]["title"] = what;
  plot.spec["description"] = plot.summary = "Histograms of the leaves of each structure by " + what;
  plot.caption = "<b>Leaves by " + what + ",</b> as shares of all leaves of a structure; the last thousandth is not shown.";
  return plot;
}

}  // namespace

std::optional<ReportPlot> pareto_plot(const ReportData& data) {
  Json marks = Json::array();
  double lanes_height = 0;
  for (const std::string& kind : data.kinds()) lanes_height = std::max(lanes_height, add_marks(marks, data, kind));
  const bool judged = std::any_of(marks.begin(), marks.end(), [](const Json& mark) { return mark["role"] == "ours"; });
  if (!judged) return std::nullopt;
  ReportPlot plot{
      "plot-pareto",
      "<b>Time against error.</b> A mark is a method" + std::string(data.have_tests() ? " with a triangle test" : "") +
          ". Lower and further left is better; the dashed line is the front, which no method beats in both. The scale of "
          "errors is linear below its first tick. Where no hit was wrong, a thin line reaches up to the 95 % bound, 3/N. "
          "Above: Embree's modes at their speed; diamonds show the errors of those that are judged." +
          errors_note(data),
      "Scatter plots of nanoseconds a ray against wrong hits per million, one for each kind of rays; the table of speeds has "
      "the same numbers",
      Json::parse(report_parts::pareto)};
  set_error_scale(plot.spec, marks);
  set_parameter(plot.spec, "lanes_height", lanes_height);
  set_method_scales(plot.spec, data, marks);
  plot.spec["facet"]["sort"] = data.kinds();
  plot.spec["data"]["values"] = std::move(marks);
  return plot;
}

std::optional<ReportPlot> speed_plot(const ReportData& data) {
  Json bars = Json::array();
  for (const std::string& kind : data.kinds())
    for (const ReportRow* row : data.rows(kind))
      if (row->ns > 0) bars.push_back(bar_of(data, *row, data.embree(kind)));
  if (bars.empty()) return std::nullopt;
  ReportPlot plot{
      "plot-speed",
      "<b>Speed by method.</b> Medians; lines reach from the least to the most of all runs. The dashed line is Embree, single "
      "rays; "
      "numbers are multiples of its speed.",
      "Bars of millions of rays a second by method, one panel for each kind of rays; the table of speeds has the same numbers",
      Json::parse(report_parts::speed)};
  Json& color = plot.spec["spec"]["layer"][0]["encoding"]["color"];
  Json domain = Json::array(), range = Json::array();
  const std::vector<std::string> states = distinct(bars, "what");
  for (std::size_t i = 0; i < color["scale"]["domain"].size(); ++i) {
    const std::string state = color["scale"]["domain"][i];
    if (std::find(states.begin(), states.end(), state) == states.end()) continue;
    domain.push_back(state), range.push_back(color["scale"]["range"][i]);
  }
  color["scale"] = {{"domain", domain}, {"range", range}};
  plot.spec["facet"]["sort"] = data.kinds();
  for (Json& layer : plot.spec["spec"]["layer"])
    if (layer["encoding"].contains("y")) layer["encoding"]["y"]["sort"] = bar_order(data);
  plot.spec["data"]["values"] = std::move(bars);
  return plot;
}

std::optional<ReportPlot> leaf_sizes_plot(const ReportData& data) {
  return histogram_plot(data, "leaf_sizes", "triangles in a leaf");
}

std::optional<ReportPlot> leaf_depths_plot(const ReportData& data) { return histogram_plot(data, "leaf_depths", "depth"); }

std::optional<ReportPlot> scaling_plot(const ReportData& data) {
  if (!data.json().contains("scaling")) return std::nullopt;
  Json points = Json::array();
  std::vector<std::string> methods;
  for (const Json& point : data.json()["scaling"]) {
    const std::string method = point["method"];
    if (std::find(methods.begin(), methods.end(), method) == methods.end()) methods.push_back(method);
    const double triangles = point["triangles"];
    const auto add = [&](const char* what, double value) {
      points.push_back({{"what", what}, {"method", method}, {"triangles", triangles}, {"value", value}});
    };
    add("ns a ray", point["ns_per_ray"]);
    add("build, ns a triangle", 1e9 * point["build_seconds"].get<double>() / triangles);
    add("bytes a triangle", point["bytes"].get<double>() / triangles);
  }
  ReportPlot plot{
      "plot-scaling",
      "<b>Scaling.</b> The first kind of rays in the built-in scene of several sizes. On a logarithmic axis of "
      "triangles, logarithmic growth is a straight line.",
      "Lines of time a ray, build time and memory a triangle over the number of triangles; the table of scaling has "
      "the same numbers",
      Json::parse(report_parts::scaling)};
  Json colors = Json::array();
  for (std::size_t m = 0; m < methods.size(); ++m) colors.push_back(kMethodColors[m % std::size(kMethodColors)]);
  plot.spec["spec"]["encoding"]["color"]["scale"] = {{"domain", methods}, {"range", colors}};
  plot.spec["data"]["values"] = std::move(points);
  return plot;
}

std::string figure_html(const std::optional<ReportPlot>& plot) {
  if (!plot) return "";
  return "<figure class=\"plot\" id=\"" + plot->id + "\">\n<div class=\"drawing\" role=\"img\" aria-label=\"" +
         html_escaped(plot->summary) + "\"></div>\n<script type=\"application/json\">" + json_in_script(plot->spec.dump()) +
         "</script>\n<figcaption>" + plot->caption + "</figcaption>\n</figure>\n";
}

}  // namespace accel::apps
