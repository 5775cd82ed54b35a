// Settings that every program has.
#pragma once

#include <cstdint>
#include <string>

#include "apps/common/failure.h"
#include "apps/common/terminal.h"

namespace accel::apps {

struct CommonSettings {
  int threads = 0;  // 0: as many as the machine has
  std::uint64_t seed = 1;
  Verbosity verbosity = Verbosity::normal;
  When progress = When::automatic;
  When color = When::automatic;
  std::string command_line;  // as it was typed, for reports
};

}  // namespace accel::apps
