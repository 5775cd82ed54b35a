// The walk of structure/bvh2_walk.h in parallel, for annotation passes.
#pragma once

#include <tbb/parallel_invoke.h>

#include "libaccel/structure/bvh2_walk.h"

namespace accel {

// Levels of the tree whose two subtrees are visited concurrently: some thousand tasks.
inline constexpr int kParallelBvh2Levels = 10;

// visit(place) is called for each node and leaf, after its parent; subtrees are visited concurrently.
template <class Visit>
void walk_bvh2_parallel(const Bvh2View& view, const Bvh2Place& place, std::uint64_t multiplier, const Visit& visit,
                        int level = 0) {
  if (level == kParallelBvh2Levels) {
    walk_bvh2(view, place, multiplier, [&](const Bvh2Place& below) { return visit(below), true; });
    return;
  }
  visit(place);
  if (is_leaf(place.ref)) return;
  const auto walk_child = [&](std::uint32_t side) {
    walk_bvh2_parallel(view, place.child(view, side, multiplier), multiplier, visit, level + 1);
  };
  tbb::parallel_invoke([&] { walk_child(0); }, [&] { walk_child(1); });
}

}  // namespace accel
