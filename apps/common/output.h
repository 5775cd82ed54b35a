// Text files, written whole or not at all.
#pragma once

#include <string>
#include <string_view>

#include "apps/common/failure.h"

namespace accel::apps {

Finished write_text(const std::string& path, std::string_view text);

}  // namespace accel::apps
