#include "apps/common/report_pictures.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/common/html.h"
#include "apps/common/image.h"
#include "apps/common/text.h"

namespace accel::apps {

namespace {

// Colours for light and dark pages and all kinds of eyes: what agrees stays back, what is wrong does not.
struct ClassColor {
  const char* name;
  Vec3 color;
};
constexpr ClassColor kClassColors[] = {
    {"not judged", {0.72f, 0.72f, 0.74f}}, {"agree", {0.87f, 0.90f, 0.93f}}, {"right", {0.70f, 0.80f, 0.86f}},
    {"neighbour", {0.00f, 0.45f, 0.70f}},  {"edge", {0.00f, 0.62f, 0.45f}},  {"far", {0.90f, 0.62f, 0.00f}},
    {"false", {0.80f, 0.47f, 0.65f}},      {"miss", {0.84f, 0.37f, 0.00f}},  {"no rays", {0.97f, 0.97f, 0.98f}}};

std::string image(const std::string& png, const std::string& alt, PictureSize size) {
  return print("<img width=\"%u\" height=\"%u\" alt=\"", size.width, size.height) + html_escaped(alt) +
         "\" src=\"data:image/png;base64," + base64(png) + "\">\n";
}

// The value that 99.5 % of the pixels of a picture do not exceed.
double high_value(const HeatPicture& picture) {
  std::vector<float> values;
  std::copy_if(picture.values.begin(), picture.values.end(), std::back_inserter(values),
               [](float v) { return std::isfinite(v); });
  if (values.empty()) return 0;
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(0.995 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

double mean(const HeatPicture& picture) {
  double sum = 0, count = 0;
  for (const float value : picture.values)
    if (std::isfinite(value)) sum += value, ++count;
  return count > 0 ? sum / count : 0;
}

// The colour bar, with ticks at powers of two.
Outcome<std::string> scale_html(double top, const std::string& unit) {
  constexpr std::uint32_t kWidth = 256;
  HeatPicture bar{{kWidth, 1}, {}, {}, {}};
  for (std::uint32_t x = 0; x < kWidth; ++x)
    bar.values.push_back(static_cast<float>(std::exp2(x / (kWidth - 1.0) * std::log2(1 + top)) - 1));
  const auto png = heat_png(bar, top);
  if (!png) return png.failure();
  std::string ticks = "<span style=\"left:0\">0</span>";
  const double factor = top > 200 ? 4 : 2;
  for (double tick = 1; tick <= top; tick *= factor)
    ticks += print("<span style=\"left:%.1f%%\">%g</span>", 100 * std::log2(1 + tick) / std::log2(1 + top), tick);
  return "<div class=\"scale\">" + image(*png, "Colours from 0 to " + short_number(top) + " " + unit, {kWidth, 1}) +
         "<div class=\"ticks\" aria-hidden=\"true\">" + ticks + "</div></div>\n";
}

std::string color_text(Vec3 color) {
  const auto byte = [](float x) { return static_cast<int>(std::lround(x * 255)); };
  return print("#%02x%02x%02x", byte(color.x), byte(color.y), byte(color.z));
}

// The classes that occur in any of the maps.
std::string classes_html(std::span<const MethodPictures> pictures) {
  std::string items;
  for (const ClassColor& c : kClassColors) {
    const bool occurs = std::any_of(pictures.begin(), pictures.end(), [&](const MethodPictures& p) {
      return p.verdicts && std::any_of(p.verdicts->classes.begin(), p.verdicts->classes.end(),
                                       [&](const ClassPicture::Class& k) { return k.name == c.name && k.rays > 0; });
    });
    if (occurs)
      items += "<li><span class=\"swatch\" style=\"background:" + color_text(c.color) + "\"></span>" + c.name + "</li>\n";
  }
  return items.empty() ? "" : "<ul class=\"classes\" aria-label=\"Verdicts\">\n" + items + "</ul>\n";
}

ClassPicture in_page_colors(ClassPicture picture) {
  for (ClassPicture::Class& c : picture.classes)
    for (const ClassColor& mine : kClassColors)
      if (c.name == mine.name) c.color = mine.color;
  return picture;
}

std::string item_html(const std::string& name, const std::string& number, const std::string& png, const std::string& alt,
                      PictureSize size) {
  return "<li>" + image(png, alt, size) + "<div class=\"name\"><span>" + html_escaped(name) + "</span><span>" +
         html_escaped(number) + "</span></div></li>\n";
}

Outcome<std::string> steps_html(std::span<const MethodPictures> pictures) {
  double top = 1;
  for (const MethodPictures& p : pictures) top = std::max(top, high_value(p.steps));
  const std::string unit = pictures.front().steps.unit;
  const auto scale = scale_html(top, unit);
  if (!scale) return scale.failure();
  std::string items;
  for (const MethodPictures& p : pictures) {
    const auto png = heat_png(p.steps, top);
    if (!png) return png.failure();
    const std::string average = short_number(mean(p.steps));
    items += item_html(p.method, average, *png, "Steps of " + p.method + " by pixel, " + average + " on average", p.steps.size);
  }
  return "<h3>By pixel: " + html_escaped(unit) + "</h3>\n<p class=\"note\">" + html_escaped(pictures.front().rays_kind) +
         " rays, on one logarithmic scale for all methods; numbers are means.</p>\n" + *scale + "<ul class=\"pictures\">\n" +
         items + "</ul>\n";
}

std::string verdicts_alt(const ClassPicture& picture) {
  std::vector<std::string> parts;
  for (const ClassPicture::Class& c : picture.classes)
    if (c.rays > 0) parts.push_back(c.name + " " + with_commas(c.rays));
  return "Verdicts by pixel: " + join(parts, ", ");
}

// The methods that have the map of the one at a place; none if it stands beside an earlier one.
std::vector<std::string> methods_with_map(std::span<const MethodPictures> pictures, std::size_t at) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (!pictures[at].verdicts || !pictures[i].verdicts || pictures[i].verdicts->values != pictures[at].verdicts->values)
      continue;
    if (i < at) return {};
    names.push_back(pictures[i].method);
  }
  return names;
}

Outcome<std::string> verdicts_html(std::span<const MethodPictures> pictures) {
  std::string items;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const std::vector<std::string> names = methods_with_map(pictures, i);
    if (names.empty()) continue;
    const ClassPicture& map = *pictures[i].verdicts;
    const auto png = class_png(in_page_colors(map));
    if (!png) return png.failure();
    const std::string count = names.size() > 3 ? std::to_string(names.size()) + " methods: " : "";
    items += item_html(count + join(names, ", "), "", *png, verdicts_alt(map), map.size);
  }
  if (items.empty()) return items;
  return "<h3>By pixel: verdicts</h3>\n<p class=\"note\">The gravest among the rays of a pixel; methods with the same map "
         "share "
         "it. "
         "Pixels that stand out as <i>right</i> are the judged sample.</p>\n" +
         classes_html(pictures) + "<ul class=\"pictures\">\n" + items + "</ul>\n";
}

}  // namespace

std::string pictures_html(std::span<const MethodPictures> pictures) {
  if (pictures.empty()) return "";
  const auto steps = steps_html(pictures);
  const auto verdicts = steps ? verdicts_html(pictures) : steps;
  if (!verdicts) return "<p class=\"note\">Pictures were left out: " + html_escaped(verdicts.failure().message) + ".</p>\n";
  return *steps + *verdicts;
}

}  // namespace accel::apps
