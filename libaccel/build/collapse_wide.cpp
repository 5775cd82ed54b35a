#include "libaccel/build/collapse_wide.h"

#include <limits>
#include <vector>

#include <tbb/parallel_invoke.h>

#include "libaccel/build/bvh2_walk_parallel.h"
#include "libaccel/build/wide_forests.h"
#include "libaccel/build/wide_layout.h"

namespace accel {
namespace {

// Finds the cheapest forests of all binary nodes, from the leaves up.
class Chooser {
 public:
  Chooser(const Bvh2& bvh, const BuildOptions& options)
      : bvh_(bvh), options_(options), forests_(bvh.nodes.size()), triangles_(bvh.nodes.size()) {
    const double root_area = half_area_in_double(bvh.bounds);
    scale_ = root_area > 0 ? 1 / root_area : 0;
  }

  Buffer<WideForests> run() {
    choose_below(bvh_.root, 0);
    return forests_;
  }

 private:
  void choose_below(NodeRef ref, int level) {
    if (is_leaf(ref)) return;
    if (level == kParallelBvh2Levels) return choose_one_by_one(ref);
    const NodeRef* const child = bvh_.nodes[ref].child;
    tbb::parallel_invoke([&] { choose_below(child[0], level + 1); }, [&] { choose_below(child[1], level + 1); });
    choose(ref);
  }

  void choose_one_by_one(NodeRef root) {
    std::vector<NodeRef> parents_first, pending{root};
    while (!pending.empty()) {
      const NodeRef ref = pending.back();
      pending.pop_back();
      parents_first.push_back(ref);
      for (const NodeRef child : bvh_.nodes[ref].child)
        if (!is_leaf(child)) pending.push_back(child);
    }
    for (auto at = parents_first.rbegin(); at != parents_first.rend(); ++at) choose(*at);
  }

  // When those of both children are chosen.
  void choose(NodeRef ref) {
    const Bvh2Node& node = bvh_.nodes[ref];
    Aabb box = node.bounds(0);
    box.extend(node.bounds(1));
    std::uint32_t sum = 0;
    WideForests forests[2];
    for (int c = 0; c < 2; ++c) {
      const std::uint32_t size = is_leaf(node.child[c]) ? leaf_size(node.child[c]) : triangles_[node.child[c]];
      forests[c] = is_leaf(node.child[c]) ? WideForests(leaf_cost(area_of(node.bounds(c)), size)) : forests_[node.child[c]];
      sum += size;
    }
    triangles_[ref] = sum;
    const float area = area_of(box);
    const bool fits = sum <= static_cast<std::uint32_t>(options_.max_leaf_size);
    forests_[ref].choose(forests[0], forests[1], area * options_.traversal_cost,
                         fits ? leaf_cost(area, sum) : std::numeric_limits<float>::infinity());
  }

  // A share of the root's.
  float area_of(const Aabb& box) const { return static_cast<float>(half_area_in_double(box) * scale_); }

  float leaf_cost(float area, std::uint32_t triangles) const {
    return area * options_.intersection_cost * static_cast<float>(blocks_for(triangles));
  }

  std::uint32_t leaf_size(NodeRef leaf) const {
    return (terminator_of(bvh_.leaves.data(), leaf) - leaf_quad(leaf)) / kQuadsPerTriangle;
  }

  const Bvh2& bvh_;
  const BuildOptions& options_;
  double scale_;
  Buffer<WideForests> forests_;
  Buffer<std::uint32_t> triangles_;  // below each node
};

}  // namespace

Result<Bvh8> collapse_wide(const Bvh2& bvh, const BuildOptions& options) {
  if (bvh.root == kNoNode) return Bvh8{};
  return lay_out_wide(bvh, Chooser(bvh, options).run());
}

std::uint64_t collapse_peak_bytes(const Bvh2& bvh, const Bvh8& wide) {
  const std::uint64_t forests = bvh.nodes.size() * (sizeof(WideForests) + sizeof(std::uint32_t));
  return bvh.size_bytes() + forests + wide_layout_peak_bytes(wide);
}

}  // namespace accel
