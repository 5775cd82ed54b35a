// What the programs find in the module that OpenImageIO is linked with: the functions of apps/common/image.h that write.
#pragma once

#include "apps/common/image.h"

namespace accel::apps {

struct ImageFunctions {
  decltype(&write_shaded) shaded;
  decltype(&write_heat) heat;
  decltype(&write_classes) classes;
  decltype(&accel::apps::heat_png) heat_png;
  decltype(&accel::apps::class_png) class_png;
};

// The module's one symbol, a function of this type.
using GetImageFunctions = const ImageFunctions*();
inline constexpr const char* kGetImageFunctions = "accel_image_functions";

}  // namespace accel::apps
