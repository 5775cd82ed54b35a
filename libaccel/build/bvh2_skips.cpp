#include "libaccel/build/bvh2_skips.h"

#include <algorithm>
#include <vector>

#include <tbb/parallel_for.h>

namespace accel {
namespace {

// Whether child 1 comes first for directions of the octant; bit a of the octant is set where component a is negative.
std::uint32_t first_in_octant(const Bvh2Node& node, std::uint32_t octant) {
  float ahead = 0;  // of child 1 before child 0, along the diagonal, times two
  for (int a = 0; a < 3; ++a) {
    const float difference = (node.planes[a][1] + node.planes[a][3]) - (node.planes[a][0] + node.planes[a][2]);
    ahead += (octant >> a & 1u) != 0 ? -difference : difference;
  }
  return ahead < 0 ? 1u : 0u;
}

// Hands the target down: a first child's subtree is followed by its sibling, that is, by the second child of its parent; a
// second child's by what follows its parent.
void fill_targets(const Bvh2& bvh, std::uint32_t* skips) {
  struct Pending {
    NodeRef node;
    std::uint32_t target;
  };
  std::vector<Pending> pending{{bvh.root, kNoSkip}};
  while (!pending.empty()) {
    const auto [node, target] = pending.back();
    pending.pop_back();
    skips[node] = (skips[node] & kSkipOrderBit) | target;
    const std::uint32_t first = first_child(skips[node]);
    const NodeRef* const child = bvh.nodes[node].child;
    if (!is_leaf(child[first ^ 1u])) pending.push_back({child[first ^ 1u], target});
    if (!is_leaf(child[first])) pending.push_back({child[first], node});
  }
}

}  // namespace

void add_skips(Bvh2& bvh) {
  if (bvh.nodes.empty()) return;
  Buffer<std::uint32_t> skips(bvh.nodes.size());
  std::fill(skips.begin(), skips.end(), 0u);
  fill_targets(bvh, skips.data());
  bvh.skips = skips;
}

void add_octant_skips(Bvh2& bvh) {
  if (bvh.nodes.empty()) return;
  const std::size_t count = bvh.nodes.size();
  Buffer<std::uint32_t> skips(kOctants * count);
  tbb::parallel_for(0u, kOctants, [&](std::uint32_t octant) {
    std::uint32_t* const order = skips.data() + octant * count;
    for (std::size_t i = 0; i < count; ++i) order[i] = first_in_octant(bvh.nodes[i], octant) << 31;
    fill_targets(bvh, order);
  });
  bvh.octant_skips = skips;
}

}  // namespace accel
