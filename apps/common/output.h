// Text files, written whole or not at all.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "apps/common/failure.h"

namespace accel::apps {

Finished write_text(const std::string& path, std::string_view text);

// Whether files can be made where the paths say, found out before work is done that would be lost. Empty paths and "-" pass.
Finished check_writable(std::initializer_list<std::string_view> paths);

}  // namespace accel::apps
