// What the pictures show, computed from rays and hits; image.h writes it to files.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "libaccel/core/hit.h"
#include "libaccel/geometry/triangle_source.h"
#include "libaccel/rays/ray_sets.h"

namespace accel::apps {

struct PictureSize {
  std::uint32_t width = 0, height = 0;
  std::size_t pixels() const { return std::size_t{width} * height; }
};

// A view of the scene: colours in linear light with sRGB's primaries, and the surface that the first ray of every pixel met.
struct ShadedPicture {
  struct Surface {
    Hit hit;
    Vec3 normal;  // geometric, of unit length, facing the viewer; zero where nothing was hit
  };

  PictureSize size;
  std::vector<Vec3> colors;
  std::vector<Surface> surfaces;
};

// How open the surroundings of hits are, from 0 to 1 for each ray; used to darken corners. Empty: everything is open.
using Openness = std::span<const float>;

// Shades each hit by its normal: a tint that shows the direction, a soft light at the viewer and one from the sky. Rays of a
// pixel are averaged. Expects one hit a ray, and rays that belong to pixels.
ShadedPicture shade(const TriangleSource& triangles, const RaySet& primary, std::span<const Hit> hits, PictureSize size,
                    Openness openness = {});

// One number a pixel, drawn through a colour map.
struct HeatPicture {
  PictureSize size;
  std::vector<float> values;  // NaN: no ray belongs to the pixel
  std::string title, unit;
};

// The mean of a number over the rays of each pixel.
HeatPicture mean_by_pixel(std::span<const std::uint32_t> numbers, const RaySet& set, PictureSize size);

// Smaller by whole factors, so that no side is longer than `most`: the means of blocks of pixels.
HeatPicture shrunk(const HeatPicture& picture, std::uint32_t most);

// One of several classes a pixel, each with its colour, beside a heat map of the same size.
struct ClassPicture {
  struct Class {
    std::string name;
    Vec3 color;  // as displayed (encoded in sRGB)
    std::uint64_t rays = 0;
  };

  PictureSize size;
  std::vector<Class> classes;
  std::vector<std::uint8_t> values;  // per pixel: an index into classes
  std::string title;
};

// Likewise: of a block of pixels the last class, but for the last of all, which is of pixels without rays.
ClassPicture shrunk(const ClassPicture& picture, std::uint32_t most);

}  // namespace accel::apps
