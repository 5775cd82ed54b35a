// What functions of the library return where memory ends: an Error, since nothing may be thrown across the interface.
//
//   Result<Mesh> load(const Path& path) try {
//     ...
//   } catch (const std::bad_alloc&) {
//     return out_of_memory("loading a mesh");
//   }
//
// Making a message takes memory too: it is put together here, and falls back to one that needs none.
#pragma once

#include <new>
#include <string>
#include <string_view>

#include "libaccel/core/result.h"

namespace accel {

// "out of memory while" and what was done; just "out of memory" where there is none for more.
inline Error out_of_memory(std::string_view doing) noexcept {
  try {
    return Error{"out of memory while " + std::string(doing)};
  } catch (const std::bad_alloc&) {
    return Error{"out of memory"};  // short enough for a std::string to hold in itself
  }
}

}  // namespace accel
