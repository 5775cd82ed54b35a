// Arguments of command lines that people copy into a POSIX shell.
#pragma once

#include <string>

namespace accel::validation {

// The argument as the shell reads it back: as it is where all of its characters are plain, otherwise in single quotes.
std::string shell_quoted(const std::string& argument);

}  // namespace accel::validation
