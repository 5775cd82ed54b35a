#include "apps/common/program_files.h"

namespace accel::apps {

std::filesystem::path find_program_file(const std::filesystem::path& installed, const std::filesystem::path& name) {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  for (const std::filesystem::path& folder : {program, program / installed})
    if (std::filesystem::exists(folder / name, error)) return folder / name;
  return {};
}

}  // namespace accel::apps
