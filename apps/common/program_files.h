// Files that come with the programs and are read when they are needed.
#pragma once

#include <filesystem>

namespace accel::apps {

// Next to the program, as in a build folder, or where an installation has it: `installed` is that folder, from the program's.
// Empty where it is in neither.
std::filesystem::path find_program_file(const std::filesystem::path& installed, const std::filesystem::path& name);

}  // namespace accel::apps
