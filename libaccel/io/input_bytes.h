// All bytes of an input file in memory: mapped, or unpacked where its name ends in .zst.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "libaccel/core/progress.h"
#include "libaccel/core/result.h"

namespace accel {

struct InputBytes {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> keep_alive;

  std::string_view text() const { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }
};

// Whether the name ends in .zst, in any case of letters.
bool is_zstd_name(const std::filesystem::path& path);

// Errors: the file cannot be mapped; a packed file is damaged, ends early, or needs more memory than there is.
Result<InputBytes> read_input(const std::filesystem::path& path, const Progress& progress = {});

}  // namespace accel
