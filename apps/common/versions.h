// Which versions and optional parts a program was built with.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace accel::apps {

// Name and version, or why there is none: libaccel, compiler, Embree, OpenImageIO, Vega-Lite.
std::vector<std::pair<std::string, std::string>> versions();

// What --version prints.
std::string versions_text(const std::string& program);

}  // namespace accel::apps
