// What --list prints.
#pragma once

#include <string>

namespace accel::apps {

// Methods, triangle tests, kinds of rays and built-in scenes.
std::string listing();

}  // namespace accel::apps
