// How batches of rays are traced on CPUs.
#pragma once

#include "libaccel/packet/packet_options.h"

namespace accel {

struct BatchSettings {
  int threads;            // 0: as many as the machine has; 1: the calling thread alone
  PacketOptions packets;  // for traversers that make packets

  // Implicitly, where only threads matter.
  BatchSettings(int threads_wanted, const PacketOptions& packet_options = {})
      : threads(threads_wanted), packets(packet_options) {}
};

}  // namespace accel
