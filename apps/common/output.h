// Text files, written whole or not at all.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "apps/common/failure.h"

namespace accel::apps {

Finished write_text(const std::string& path, std::string_view text);

struct OutputFile {
  std::string_view flag, path;  // the option that names it; empty: none, "-": standard output
};

// Whether files can be made where the paths say, and each is another one, found out before work is done that would be lost. Two
// outputs to one file are a usage error.
Finished check_outputs(std::initializer_list<OutputFile> files);

}  // namespace accel::apps
