// Rates of wrong hits as people read them.
#pragma once

#include <string>

#include "validation/compare/compare.h"

namespace accel::apps {

// Per million: "3194", "< 15.3" where nothing was found, and a dash where nothing was tried.
std::string rate_text(const validation::Rate& rate);

}  // namespace accel::apps
