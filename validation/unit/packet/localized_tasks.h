// The rays of a scene's packets with the leaves that their frustums meet, for tests of localized intersection.
#pragma once

#include <utility>
#include <vector>

#include "libaccel/geometry/watertight.h"
#include "libaccel/packet/depth_first.h"
#include "libaccel/packet/localized_warp.h"
#include "validation/unit/packet/packets_of_rays.h"

namespace accel::test {

struct TaskArrays {
  std::vector<Ray> rays;
  std::vector<LocalizedTask> tasks;
  std::vector<std::uint32_t> firsts, places;

  // Packets whose frustums meet anything. Tasks come from the last ray of a packet to the first: places are not numbers.
  TaskArrays(const TriangleMesh& mesh, const Bvh2& tree, std::uint64_t seed) {
    DepthFirst<> traversal;
    for (const auto& packet : packets_for(mesh, tree.bounds, seed)) {
      const Frustum frustum = frustum_of(packet, tree.bounds);
      const auto& found = traversal.run(tree.view(), &frustum, 1).place;
      if (found.empty()) continue;
      const auto first = static_cast<std::uint32_t>(rays.size()), active = static_cast<std::uint32_t>(firsts.size());
      for (auto i = static_cast<std::uint32_t>(packet.size()); i-- > 0;) tasks.push_back({first + i, active});
      rays.insert(rays.end(), packet.begin(), packet.end());
      firsts.push_back(static_cast<std::uint32_t>(places.size()));
      places.insert(places.end(), found.begin(), found.end());
    }
    firsts.push_back(static_cast<std::uint32_t>(places.size()));
  }

  LocalizedTasks view(const Bvh2& tree) const {
    return {tree.octo.data(),
            tree.leaves.data(),
            rays.data(),
            tasks.data(),
            firsts.data(),
            places.data(),
            static_cast<std::uint32_t>(tasks.size())};
  }

  // One ray by itself: [GL10], Fig. 10.
  template <Query kQuery, class Observer>
  Hit alone(const Bvh2& tree, const LocalizedTask& task, Observer& observer) const {
    const std::uint32_t first = firsts[task.active], count = firsts[task.active + 1] - first;
    return intersect_leaves<Watertight, kQuery>(tree.octo.data(), tree.leaves.data(), rays[task.ray], places.data() + first,
                                                count, observer);
  }
};

}  // namespace accel::test
