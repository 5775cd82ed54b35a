// SIGINT and SIGTERM, turned into a flag that long-running work looks at, so that nothing is left half-written.
#pragma once

#include "apps/common/exit_status.h"

namespace accel::apps {

// From now on the first of these signals sets the flag and the second ends the program at once.
void catch_interrupts();

bool interrupted();

// The exit status of interrupted work: 128 and the number of the signal, as shells have it.
ExitStatus interruption_status();

}  // namespace accel::apps
