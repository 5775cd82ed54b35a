// Pictures as files, by OpenImageIO; everything here fails politely in builds without it.
//
// OpenImageIO brings some 250 libraries, which take longer to load than most commands take to run. So it is linked with a
// module (apps/images), the one place that includes it, which is loaded when a picture is asked for.
//
// The format is told by the file's ending: png, jpg, tif (8 bits, as displayed, encoded in sRGB) or exr (32 bits, the numbers
// themselves in named channels). Files are written whole or not at all.
#pragma once

#include <filesystem>
#include <string>

#include "apps/common/failure.h"
#include "apps/common/picture.h"

namespace accel::apps {

// Whether this program can write pictures.
bool images_available();

// "OpenImageIO 2.4.7", or why there is none.
std::string image_library_version();

// The end of the name that tells the format, in small letters: "png".
std::string image_ending(const std::filesystem::path& path);

// Fails where a picture of this name could not be written: no image library, or it cannot be loaded (unavailable), an unknown
// ending (usage).
Finished check_image_name(const std::filesystem::path& path, std::string_view flag);

// EXR: R, G, B, prim_id (uint32, 0xffffffff is a miss), t, u, v, Nx, Ny, Nz; the last seven of a pixel's first ray.
Finished write_shaded(const std::filesystem::path& path, const ShadedPicture& picture);

// The values through a colour map that reaches from 0 to the 99.5th percentile, under a title and over a legend in `unit`. EXR:
// one channel named `channel`.
Finished write_heat(const std::filesystem::path& path, const HeatPicture& picture, const std::string& channel);

// A heat map on a logarithmic scale and a map of classes side by side, with their legends. EXR: the channels `channel` and
// class.
Finished write_classes(const std::filesystem::path& path, const HeatPicture& heat, const ClassPicture& classes,
                       const std::string& channel);

// Pictures alone, without title and legend, as the bytes of a PNG file: values through a colour map that reaches from 0 to `top`
// on a logarithmic scale, log(1 + value); and classes in their colours.
Outcome<std::string> heat_png(const HeatPicture& picture, double top);
Outcome<std::string> class_png(const ClassPicture& picture);

}  // namespace accel::apps
