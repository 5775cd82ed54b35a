// The library's version. This is the one place where it is written: CMakeLists.txt reads it from here.
#pragma once

namespace accel {

inline constexpr const char* kVersion = "0.1.0";

}  // namespace accel
