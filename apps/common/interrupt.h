// SIGINT, turned into a flag that long-running work looks at, so that nothing is left half-written.
#pragma once

namespace accel::apps {

// From now on the first SIGINT sets the flag and the second ends the program at once.
void catch_interrupts();

bool interrupted();

}  // namespace accel::apps
