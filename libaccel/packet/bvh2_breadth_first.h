// Traces batches of rays as packets: Garanzha and Loop 2010, "Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray
// Tracing". packet/packet_tracer.h is what CPUs run, packet/packet_batch.h what devices run.
//
// Hits are those of single rays. In the registry the method is a traverser that is the stack version in all that concerns
// single rays: what counts their steps or models warps or streams sees that one.
#pragma once

#include "libaccel/packet/packet_tracer.h"
#include "libaccel/trace/bvh2_stack.h"

namespace accel {

// Executors on CPUs trace batches by `Batch`: see exec/cpu.h.
template <class Test, Query kQuery>
struct Bvh2BreadthFirst : Bvh2Stack<Test, kQuery> {
  static constexpr const char* kName = "breadth-first";
  static constexpr Bvh2Extras kNeeds = Bvh2Extras::octo;
  static constexpr SkippedFeature kSkips{"steps of packets",
                                         "counters, profiles and single rays are those of the stack version"};

  template <class TraceSingly>
  using Batch = PacketTracer<Test, kQuery, TraceSingly>;
};

}  // namespace accel
