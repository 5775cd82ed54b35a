// Pictures of a run on its report's page: the steps of each method and its verdicts, by pixel of the first kind of rays that
// has pixels.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "apps/common/picture.h"

namespace accel::apps {

struct MethodPictures {
  std::string method, rays_kind;
  HeatPicture steps;
  std::optional<ClassPicture> verdicts;  // where hits are checked
};

// The longest side that pictures have on the page, so that a page of all methods stays below a few megabytes.
inline constexpr std::uint32_t kMostReportPixels = 320;

// Pictures with their legends, as markup, steps on one scale for all of them. Where no picture can be made: why.
std::string pictures_html(std::span<const MethodPictures> pictures);

}  // namespace accel::apps
