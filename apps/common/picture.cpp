#include "apps/common/picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace accel::apps {

namespace {

Vec3 unit(Vec3 v) {
  const float length = std::sqrt(dot(v, v));
  return length > 0 ? v * (1.0f / length) : Vec3{};
}

Vec3 mix(Vec3 a, Vec3 b, float share) { return a * (1.0f - share) + b * share; }

// The geometric normal, towards the viewer. Computed in double precision: tiny triangles have tiny cross products.
Vec3 facing_normal(const Triangle& t, Vec3 view) {
  const double a[3] = {double{t.v1.x} - t.v0.x, double{t.v1.y} - t.v0.y, double{t.v1.z} - t.v0.z};
  const double b[3] = {double{t.v2.x} - t.v0.x, double{t.v2.y} - t.v0.y, double{t.v2.z} - t.v0.z};
  const double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 0)) return {};
  const Vec3 normal{static_cast<float>(n[0] / length), static_cast<float>(n[1] / length), static_cast<float>(n[2] / length)};
  return dot(normal, view) > 0 ? -normal : normal;
}

// A pale sky over a warm horizon and a darker ground.
Vec3 background(Vec3 direction) {
  constexpr Vec3 kZenith{0.20f, 0.38f, 0.68f}, kHorizon{0.82f, 0.86f, 0.88f}, kGround{0.30f, 0.29f, 0.28f};
  const float height = direction.y;
  return height >= 0 ? mix(kHorizon, kZenith, std::pow(height, 0.6f)) : mix(kHorizon, kGround, std::pow(-height, 0.4f));
}

// A surface of a pale colour that its normal tints, in a soft light from the viewer and from above.
Vec3 surface_color(Vec3 normal, Vec3 view, float openness) {
  const Vec3 tint{0.5f + 0.5f * normal.x, 0.5f + 0.5f * normal.y, 0.5f + 0.5f * normal.z};
  const Vec3 base = mix(Vec3{0.84f, 0.82f, 0.78f}, tint, 0.60f);
  const float headlight = std::max(0.0f, -dot(normal, view));
  const float sky = 0.5f + 0.5f * normal.y;
  constexpr Vec3 kKeyDirection{0.45f, 0.77f, 0.45f};
  const float key = std::max(0.0f, dot(normal, kKeyDirection));
  const Vec3 light =
      Vec3{1.0f, 0.95f, 0.88f} * (0.40f * headlight + 0.55f * key) + Vec3{0.86f, 0.94f, 1.0f} * (0.18f + 0.37f * sky);
  return Vec3{base.x * light.x, base.y * light.y, base.z * light.z} * (0.25f + 0.75f * openness);
}

}  // namespace

ShadedPicture shade(const TriangleSource& triangles, const RaySet& primary, std::span<const Hit> hits, PictureSize size,
                    Openness openness) {
  ShadedPicture picture{size, std::vector<Vec3>(size.pixels()), std::vector<ShadedPicture::Surface>(size.pixels())};
  std::vector<std::uint32_t> samples(size.pixels(), 0);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const std::uint32_t pixel = primary.pixel[i];
    const Vec3 view = unit(primary.rays[i].dir);
    const Vec3 normal = hits[i].valid() ? facing_normal(triangles.triangle(hits[i].prim_id), view) : Vec3{};
    const Vec3 color = hits[i].valid() ? surface_color(normal, view, openness.empty() ? 1.0f : openness[i]) : background(view);
    if (samples[pixel]++ == 0) picture.surfaces[pixel] = {hits[i], normal};
    picture.colors[pixel] = picture.colors[pixel] + color;
  }
  for (std::size_t p = 0; p < samples.size(); ++p)
    if (samples[p] > 1) picture.colors[p] = picture.colors[p] * (1.0f / static_cast<float>(samples[p]));
  return picture;
}

HeatPicture mean_by_pixel(std::span<const std::uint32_t> numbers, const RaySet& set, PictureSize size) {
  std::vector<double> sums(size.pixels(), 0);
  std::vector<std::uint32_t> samples(size.pixels(), 0);
  for (std::size_t i = 0; i < numbers.size(); ++i) sums[set.pixel[i]] += numbers[i], ++samples[set.pixel[i]];
  HeatPicture picture{size, std::vector<float>(size.pixels(), std::numeric_limits<float>::quiet_NaN()), {}, {}};
  for (std::size_t p = 0; p < sums.size(); ++p)
    if (samples[p] > 0) picture.values[p] = static_cast<float>(sums[p] / samples[p]);
  return picture;
}

namespace {

PictureSize shrunk_size(PictureSize size, std::uint32_t factor) {
  return {(size.width + factor - 1) / factor, (size.height + factor - 1) / factor};
}

std::uint32_t shrink_factor(PictureSize size, std::uint32_t most) {
  return std::max((std::max(size.width, size.height) + most - 1) / most, 1u);
}

// Visits every pixel of a picture with the block that it belongs to.
template <class Visit>
void for_each_in_blocks(PictureSize size, std::uint32_t factor, const Visit& visit) {
  const std::uint32_t blocks_across = shrunk_size(size, factor).width;
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x)
      visit(std::size_t{y / factor} * blocks_across + x / factor, std::size_t{y} * size.width + x);
}

}  // namespace

HeatPicture shrunk(const HeatPicture& picture, std::uint32_t most) {
  const std::uint32_t factor = shrink_factor(picture.size, most);
  HeatPicture small{shrunk_size(picture.size, factor), {}, picture.title, picture.unit};
  std::vector<double> sums(small.size.pixels(), 0);
  std::vector<std::uint32_t> counts(small.size.pixels(), 0);
  for_each_in_blocks(picture.size, factor, [&](std::size_t block, std::size_t pixel) {
    if (!std::isnan(picture.values[pixel])) sums[block] += picture.values[pixel], ++counts[block];
  });
  small.values.resize(small.size.pixels(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t b = 0; b < sums.size(); ++b)
    if (counts[b] > 0) small.values[b] = static_cast<float>(sums[b] / counts[b]);
  return small;
}

ClassPicture shrunk(const ClassPicture& picture, std::uint32_t most) {
  const std::uint32_t factor = shrink_factor(picture.size, most);
  const auto none = static_cast<std::uint8_t>(picture.classes.size() - 1);
  ClassPicture small{shrunk_size(picture.size, factor), picture.classes, {}, picture.title};
  small.values.resize(small.size.pixels(), none);
  for_each_in_blocks(picture.size, factor, [&](std::size_t block, std::size_t pixel) {
    std::uint8_t& value = small.values[block];
    const std::uint8_t mine = picture.values[pixel];
    if (mine != none) value = value == none ? mine : std::max(value, mine);
  });
  return small;
}

}  // namespace accel::apps
