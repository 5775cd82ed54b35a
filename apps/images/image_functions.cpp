#include "apps/images/image_functions.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "apps/common/text.h"
#include "libaccel/core/suggest.h"
#include "libaccel/io/atomic_file.h"

namespace accel::apps {

namespace {

using OIIO::ImageBuf;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

// Writes `data` (as spec.format says, or word by word where channels differ) under a temporary name and renames it.
Finished write_pixels(const std::filesystem::path& path, ImageSpec spec, const void* data) {
  spec.attribute("Software", "libaccel");
  const std::string ending = image_ending(path);
  auto temporary = AtomicPath::create(path);
  if (!temporary) return temporary.error();
  const auto failed = [&](const std::string& why) {
    return Failure(ExitStatus::error, "cannot write picture '" + path.string() + "': " + why);
  };
  const auto output = OIIO::ImageOutput::create(ending);
  if (!output) return failed(OIIO::geterror());
  const TypeDesc data_type = spec.channelformats.empty() ? spec.format : TypeDesc(TypeDesc::UNKNOWN);
  const bool written =
      output->open(temporary->path().string(), spec) && output->write_image(data_type, data) && output->close();
  if (!written) return failed(output->geterror());
  if (const Status renamed = temporary->commit(); !renamed) return renamed.error();
  return Done{};
}

float encode_srgb(float linear) {
  const float x = std::clamp(linear, 0.0f, 1.0f);
  return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

std::uint8_t to_byte(float x) { return static_cast<std::uint8_t>(std::lround(std::clamp(x, 0.0f, 1.0f) * 255.0f)); }

// A canvas of displayed colours (sRGB) to draw on.
class Canvas {
 public:
  Canvas(int width, int height) : buffer_(ImageSpec(width, height, 3, TypeDesc::FLOAT)) {
    fill({0, 0, width, height}, kPaper);
    font_ = find_font();
  }

  struct Box {
    int x0, y0, x1, y1;
  };
  static constexpr Vec3 kPaper{0.10f, 0.10f, 0.12f}, kInk{0.93f, 0.93f, 0.93f}, kFaintInk{0.62f, 0.62f, 0.66f};

  int width() const { return buffer_.spec().width; }
  ImageBuf& buffer() { return buffer_; }

  void fill(Box box, Vec3 color) {
    const float rgb[3] = {color.x, color.y, color.z};
    OIIO::ImageBufAlgo::fill(buffer_, rgb, OIIO::ROI(box.x0, box.x1, box.y0, box.y1));
  }

  void set(int x, int y, Vec3 color) {
    const float rgb[3] = {color.x, color.y, color.z};
    buffer_.setpixel(x, y, rgb, 3);
  }

  void paste(int x, int y, const ImageBuf& image) { OIIO::ImageBufAlgo::paste(buffer_, x, y, 0, 0, image); }

  // Text whose baseline is at y; nothing where no font was found: ticks and colours then stand alone.
  enum class Anchor { left, center, right };
  void text(int x, int y, const std::string& words, int size, Anchor anchor = Anchor::left, Vec3 color = kInk) {
    if (font_.empty()) return;
    const float rgb[3] = {color.x, color.y, color.z};
    const auto align = anchor == Anchor::left     ? OIIO::ImageBufAlgo::TextAlignX::Left
                       : anchor == Anchor::center ? OIIO::ImageBufAlgo::TextAlignX::Center
                                                  : OIIO::ImageBufAlgo::TextAlignX::Right;
    OIIO::ImageBufAlgo::render_text(buffer_, x, y, words, size, font_, rgb, align);
  }

  int text_width(const std::string& words, int size) const {
    if (font_.empty()) return 0;
    const OIIO::ROI roi = OIIO::ImageBufAlgo::text_size(words, size, font_);
    return roi.defined() ? roi.width() : 0;
  }

  Finished write(const std::filesystem::path& path) const {
    ImageSpec spec(buffer_.spec().width, buffer_.spec().height, 3, TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    std::vector<float> values(static_cast<std::size_t>(spec.image_pixels()) * 3);
    buffer_.get_pixels(OIIO::ROI::All(), TypeDesc::FLOAT, values.data());
    std::vector<std::uint8_t> bytes(values.size());
    std::transform(values.begin(), values.end(), bytes.begin(), to_byte);
    return write_pixels(path, spec, bytes.data());
  }

 private:
  static std::string find_font() {
    for (const char* name : {"DejaVuSans", "LiberationSans-Regular", "NotoSans-Regular", "DroidSans", "FreeSans"})
      if (OIIO::ImageBufAlgo::text_size("0", 16, name).defined()) return name;
    OIIO::geterror();  // not finding one is no error
    return {};
  }

  ImageBuf buffer_;
  std::string font_;
};

// Where things stand on a page: a title, one or two pictures, a legend below each.
struct Layout {
  static constexpr int kLeastPanelWidth = 420;

  explicit Layout(PictureSize size, int panel_count)
      : picture(size),
        font(std::clamp(static_cast<int>(size.width) / 48, 13, 24)),
        margin(font),
        panel_width(std::max(static_cast<int>(size.width), kLeastPanelWidth)),
        panels(panel_count) {}

  int width() const { return panels * panel_width + (panels + 1) * margin; }
  int height() const { return top() + static_cast<int>(picture.height) + legend_height(); }
  int top() const { return 2 * margin + font; }
  int legend_top() const { return top() + static_cast<int>(picture.height) + margin; }
  int legend_height() const { return 4 * margin + 2 * font; }
  int panel_left(int panel) const { return margin + panel * (panel_width + margin); }
  int picture_left(int panel) const { return panel_left(panel) + (panel_width - static_cast<int>(picture.width)) / 2; }

  PictureSize picture;
  int font, margin, panel_width, panels;
};

// From values to the interval [0, 1] of a colour map.
struct Scale {
  double top = 1;
  bool logarithmic = false;  // log2(1 + x), for values over many magnitudes

  float place(double value) const {
    const double share = logarithmic ? std::log2(1 + value) / std::log2(1 + top) : value / top;
    return static_cast<float>(std::clamp(share, 0.0, 1.0));
  }
};

// The value that a share of the others does not exceed; 0 without values.
double percentile(const std::vector<float>& values, double share) {
  std::vector<float> finite;
  std::copy_if(values.begin(), values.end(), std::back_inserter(finite), [](float v) { return std::isfinite(v); });
  if (finite.empty()) return 0;
  const auto nth = finite.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(finite.size() - 1));
  std::nth_element(finite.begin(), nth, finite.end());
  return *nth;
}

// 1, 2 or 5 times a power of ten: the distance of about five ticks below `top`.
double tick_distance(double top) {
  const double power = std::pow(10.0, std::floor(std::log10(top / 5)));
  const double digit = top / 5 / power;
  return power * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
}

std::vector<double> ticks_of(const Scale& scale) {
  std::vector<double> ticks = {0};
  if (scale.logarithmic)
    for (double t = 1; t <= scale.top; t *= scale.top > 4096 ? 16 : 4) ticks.push_back(t);
  else
    for (double t = tick_distance(scale.top); t <= scale.top * 1.001; t += tick_distance(scale.top)) ticks.push_back(t);
  return ticks;
}

ImageBuf through_color_map(std::uint32_t width, std::uint32_t height, std::vector<float>& places) {
  const ImageSpec spec(static_cast<int>(width), static_cast<int>(height), 1, TypeDesc::FLOAT);
  const ImageBuf source(spec, places.data());
  return OIIO::ImageBufAlgo::color_map(source, 0, "turbo");
}

void draw_heat(Canvas& canvas, const Layout& layout, int panel, const HeatPicture& picture, const Scale& scale) {
  std::vector<float> places(picture.values.size());
  std::transform(picture.values.begin(), picture.values.end(), places.begin(),
                 [&](float v) { return std::isnan(v) ? 0.0f : scale.place(v); });
  canvas.paste(layout.picture_left(panel), layout.top(), through_color_map(picture.size.width, picture.size.height, places));
  for (std::size_t p = 0; p < picture.values.size(); ++p)
    if (std::isnan(picture.values[p]))
      canvas.set(layout.picture_left(panel) + static_cast<int>(p % picture.size.width),
                 layout.top() + static_cast<int>(p / picture.size.width), Canvas::kPaper * 2.2f);
}

// The colour bar with its ticks and numbers.
void draw_scale(Canvas& canvas, const Layout& layout, int panel, const HeatPicture& picture, const Scale& scale) {
  const int left = layout.panel_left(panel), y = layout.legend_top();
  const int unit_width = canvas.text_width(picture.unit, layout.font) + layout.margin;
  const int bar_width = layout.panel_width - unit_width - layout.margin;
  std::vector<float> ramp(static_cast<std::size_t>(bar_width) * static_cast<std::size_t>(layout.font));
  for (std::size_t i = 0; i < ramp.size(); ++i)
    ramp[i] = static_cast<float>(i % static_cast<std::size_t>(bar_width)) / static_cast<float>(bar_width - 1);
  canvas.paste(left, y,
               through_color_map(static_cast<std::uint32_t>(bar_width), static_cast<std::uint32_t>(layout.font), ramp));
  canvas.text(left + layout.panel_width, y + layout.font, picture.unit, layout.font, Canvas::Anchor::right);
  const std::vector<double> ticks = ticks_of(scale);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const int x = left + static_cast<int>(scale.place(ticks[i]) * static_cast<float>(bar_width - 1));
    canvas.fill({x, y + layout.font, x + 1, y + layout.font + layout.font / 3}, Canvas::kInk);
    canvas.text(x, y + 2 * layout.font + layout.font / 2, print("%g", ticks[i]), layout.font,
                i == 0 ? Canvas::Anchor::left : Canvas::Anchor::center);
  }
}

void draw_classes(Canvas& canvas, const Layout& layout, int panel, const ClassPicture& picture) {
  const std::uint32_t width = picture.size.width;
  for (std::size_t p = 0; p < picture.values.size(); ++p)
    canvas.set(layout.picture_left(panel) + static_cast<int>(p % width), layout.top() + static_cast<int>(p / width),
               picture.classes[picture.values[p]].color);
}

// A coloured square, name and count for each class that occurs, in rows of as many as fit.
void draw_class_legend(Canvas& canvas, const Layout& layout, int panel, const ClassPicture& picture) {
  int x = layout.panel_left(panel), y = layout.legend_top();
  for (const ClassPicture::Class& c : picture.classes) {
    if (c.rays == 0) continue;
    const std::string words = c.name + " " + with_commas(c.rays);
    const int width = layout.font + layout.font / 2 + canvas.text_width(words, layout.font) + layout.margin;
    if (x + width > layout.panel_left(panel) + layout.panel_width + layout.margin)
      x = layout.panel_left(panel), y += layout.font + layout.font / 2;
    canvas.fill({x, y, x + layout.font, y + layout.font}, c.color);
    canvas.text(x + layout.font + layout.font / 2, y + layout.font - layout.font / 8, words, layout.font);
    x += width;
  }
}

// Cut short where the panel has no room for it.
void draw_title(Canvas& canvas, const Layout& layout, int panel, std::string title) {
  const auto fits = [&](const std::string& words) { return canvas.text_width(words, layout.font) <= layout.panel_width; };
  if (!fits(title)) {
    while (!title.empty() && !fits(title + "...")) title.pop_back();
    title += "...";
  }
  canvas.text(layout.panel_left(panel), layout.margin + layout.font, title, layout.font);
}

// Channels of 32 bits each, floats but for the one called `integer`.
ImageSpec exr_spec(PictureSize size, std::vector<std::string> names, const std::string& integer = {}) {
  ImageSpec spec(static_cast<int>(size.width), static_cast<int>(size.height), static_cast<int>(names.size()), TypeDesc::FLOAT);
  if (!integer.empty())
    for (const std::string& name : names)
      spec.channelformats.push_back(name == integer ? TypeDesc(TypeDesc::UINT32) : TypeDesc(TypeDesc::FLOAT));
  spec.channelnames = std::move(names);
  spec.attribute("compression", "zip");
  return spec;
}

Finished write_shaded_exr(const std::filesystem::path& path, const ShadedPicture& picture) {
  const ImageSpec spec = exr_spec(picture.size, {"R", "G", "B", "prim_id", "t", "u", "v", "Nx", "Ny", "Nz"}, "prim_id");
  std::vector<std::uint32_t> words;
  words.reserve(picture.size.pixels() * 10);
  const auto add = [&](float value) { words.push_back(std::bit_cast<std::uint32_t>(value)); };
  for (std::size_t p = 0; p < picture.size.pixels(); ++p) {
    const Vec3 color = picture.colors[p], normal = picture.surfaces[p].normal;
    const Hit& hit = picture.surfaces[p].hit;
    add(color.x), add(color.y), add(color.z);
    words.push_back(hit.prim_id);
    add(hit.t), add(hit.u), add(hit.v);
    add(normal.x), add(normal.y), add(normal.z);
  }
  return write_pixels(path, spec, words.data());
}

Finished shaded_to_file(const std::filesystem::path& path, const ShadedPicture& picture) {
  if (image_ending(path) == "exr") return write_shaded_exr(path, picture);
  ImageSpec spec(static_cast<int>(picture.size.width), static_cast<int>(picture.size.height), 3, TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  std::vector<std::uint8_t> bytes;
  bytes.reserve(picture.size.pixels() * 3);
  for (const Vec3& color : picture.colors)
    for (int c = 0; c < 3; ++c) bytes.push_back(to_byte(encode_srgb(color[c])));
  return write_pixels(path, spec, bytes.data());
}

Finished heat_to_file(const std::filesystem::path& path, const HeatPicture& picture, const std::string& channel) {
  if (image_ending(path) == "exr") return write_pixels(path, exr_spec(picture.size, {channel}), picture.values.data());
  const Scale scale{std::max(percentile(picture.values, 0.995), 1.0), false};
  const Layout layout(picture.size, 1);
  Canvas canvas(layout.width(), layout.height());
  draw_title(canvas, layout, 0, picture.title);
  draw_heat(canvas, layout, 0, picture, scale);
  draw_scale(canvas, layout, 0, picture, scale);
  return canvas.write(path);
}

Finished classes_to_file(const std::filesystem::path& path, const HeatPicture& heat, const ClassPicture& classes,
                         const std::string& channel) {
  if (image_ending(path) == "exr") {
    std::vector<float> values;
    values.reserve(heat.values.size() * 2);
    for (std::size_t p = 0; p < heat.values.size(); ++p) values.push_back(heat.values[p]), values.push_back(classes.values[p]);
    return write_pixels(path, exr_spec(heat.size, {channel, "class"}), values.data());
  }
  const Scale scale{std::max(percentile(heat.values, 1.0), 4.0), true};
  const Layout layout(heat.size, 2);
  Canvas canvas(layout.width(), layout.height());
  draw_title(canvas, layout, 0, heat.title);
  draw_title(canvas, layout, 1, classes.title);
  draw_heat(canvas, layout, 0, heat, scale);
  draw_scale(canvas, layout, 0, heat, scale);
  draw_classes(canvas, layout, 1, classes);
  draw_class_legend(canvas, layout, 1, classes);
  return canvas.write(path);
}

// A PNG file in memory, of 8-bit RGB.
Outcome<std::string> png_of(PictureSize size, const std::vector<std::uint8_t>& bytes) {
  ImageSpec spec(static_cast<int>(size.width), static_cast<int>(size.height), 3, TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute("png:compressionLevel", 9);
  const auto output = OIIO::ImageOutput::create("png");
  if (!output) return Failure(ExitStatus::error, "cannot make a picture: " + OIIO::geterror());
  OIIO::Filesystem::IOVecOutput memory;
  const bool written = output->set_ioproxy(&memory) && output->open("memory.png", spec) &&
                       output->write_image(TypeDesc::UINT8, bytes.data()) && output->close();
  if (!written) return Failure(ExitStatus::error, "cannot make a picture: " + output->geterror());
  return std::string(memory.buffer().begin(), memory.buffer().end());
}

// Few colours make small files.
Outcome<std::string> heat_to_png(const HeatPicture& picture, double top) {
  constexpr float kLevels = 63;
  const Scale scale{std::max(top, 1.0), true};
  std::vector<float> places;
  for (const float v : picture.values) places.push_back(std::isnan(v) ? 0.0f : std::round(scale.place(v) * kLevels) / kLevels);
  const ImageSpec spec(static_cast<int>(picture.size.width), static_cast<int>(picture.size.height), 1, TypeDesc::FLOAT);
  const ImageBuf colors = OIIO::ImageBufAlgo::color_map(ImageBuf(spec, places.data()), 0, "inferno");
  std::vector<std::uint8_t> bytes(picture.size.pixels() * 3);
  colors.get_pixels(OIIO::ROI(0, spec.width, 0, spec.height, 0, 1, 0, 3), TypeDesc::UINT8, bytes.data());
  for (std::size_t p = 0; p < picture.values.size(); ++p)
    if (std::isnan(picture.values[p])) std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(3 * p), 3, std::uint8_t{128});
  return png_of(picture.size, bytes);
}

Outcome<std::string> class_to_png(const ClassPicture& picture) {
  std::vector<std::uint8_t> bytes;
  for (const std::uint8_t value : picture.values)
    for (int c = 0; c < 3; ++c) bytes.push_back(to_byte(picture.classes[value].color[c]));
  return png_of(picture.size, bytes);
}

}  // namespace

}  // namespace accel::apps

extern "C" [[gnu::visibility("default")]] const accel::apps::ImageFunctions* accel_image_functions() {
  static constexpr accel::apps::ImageFunctions kFunctions = {accel::apps::shaded_to_file, accel::apps::heat_to_file,
                                                             accel::apps::classes_to_file, accel::apps::heat_to_png,
                                                             accel::apps::class_to_png};
  return &kFunctions;
}
