// Sorts the events of a kd-tree builder (kdtree_events.h) along one axis.
#pragma once

#include "libaccel/build/kdtree_events.h"
#include "libaccel/build/scratch_stack.h"

namespace accel {

// Sorts events that were appended in the order of their references. O(n): many are sorted by digits, in three passes.
void sort_events(KdEvent* events, std::uint32_t count, ScratchStack& scratch);

// Merges sorted events into a list, which has room for them.
void merge_events(KdEventList& list, const KdEventList& added);

}  // namespace accel
