// What the operating system says of a file.
#pragma once

#include <cstring>
#include <filesystem>

#include "libaccel/core/result.h"

namespace accel {

inline Error system_error(const std::filesystem::path& path, const char* what, int error_number) {
  return Error{path.string() + ": " + what + ": " + std::strerror(error_number)};
}

}  // namespace accel
