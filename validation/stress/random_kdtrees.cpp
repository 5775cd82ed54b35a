#include "validation/stress/random_kdtrees.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/float_bounds.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/structure/padding.h"

namespace accel::validation {
namespace {

class RandomKdTreeBuild {
 public:
  RandomKdTreeBuild(const TriangleMesh& mesh, std::uint64_t seed, const RandomKdTreeOptions& options)
      : options_(options), rng_(seed, 0) {
    for (std::uint32_t i = 0; i < mesh.size(); ++i) {
      const Triangle triangle = mesh.triangle(i);
      if (is_in_range(triangle) && !is_zero_area(triangle)) triangles_.push_back(pack(triangle, i));
    }
  }

  KdTree run() {
    KdTree tree;
    if (triangles_.empty()) return tree;
    Aabb bounds;
    for (const PackedTriangle& t : triangles_) bounds.extend(t.vertices().bounds());
    const Vec3d pad = cell_padding(bounds);
    std::vector<std::uint32_t> slots;
    for (const PackedTriangle& t : triangles_) {
      slots.push_back(static_cast<std::uint32_t>(boxes_.size()));
      boxes_.push_back(padded(t.vertices().bounds(), pad));
    }
    nodes_.resize(2);
    nodes_[1] = KdNode::leaf(kEmptyLeaf, 0);  // unused
    tree.bounds = padded(bounds, pad);
    fill(kKdRoot, tree.bounds, std::move(slots), 0);
    tree.nodes = Buffer<KdNode>::copy_of(nodes_);
    tree.leaves.triangles = Buffer<PackedTriangle>::copy_of(triangles_);
    tree.leaves.references = Buffer<std::uint32_t>::copy_of(references_);
    tree.depth = depth_, tree.leaf_count = leaf_count_;
    return tree;
  }

 private:
  // Makes a node of the triangles in a cell.
  void fill(std::uint32_t index, const Aabb& cell, std::vector<std::uint32_t> slots, std::uint32_t level) {
    const bool is_small = slots.size() <= options_.leaf_size && rng_.next_below(4) != 0;
    const bool must_end = level >= options_.max_depth || nodes_.size() >= options_.max_nodes;
    const int axis = static_cast<int>(rng_.next_below(3));
    const float plane = random_plane(cell, axis, slots);
    const bool is_inside = plane > cell.lo[axis] && plane < cell.hi[axis];
    if (is_small || must_end || !is_inside) return make_leaf(index, slots, level);

    const auto lower = static_cast<std::uint32_t>(nodes_.size());
    nodes_[index] = KdNode::inner(axis, plane, lower);
    nodes_.resize(nodes_.size() + 2);
    for (std::uint32_t side = 0; side < 2; ++side) {
      Aabb part = cell;
      (side == 0 ? part.hi : part.lo)[axis] = plane;
      std::vector<std::uint32_t> inside;
      for (const std::uint32_t slot : slots)
        if (!intersection(boxes_[slot], part).empty()) inside.push_back(slot);
      fill(lower + side, part, std::move(inside), level + 1);
    }
  }

  void make_leaf(std::uint32_t index, const std::vector<std::uint32_t>& slots, std::uint32_t level) {
    const std::uint32_t first = slots.empty() ? kEmptyLeaf : static_cast<std::uint32_t>(references_.size());
    nodes_[index] = KdNode::leaf(first, leaf_count_++);
    references_.insert(references_.end(), slots.begin(), slots.end());
    if (!slots.empty()) references_.back() |= kLastReference;
    depth_ = std::max(depth_, level);
  }

  float random_plane(const Aabb& cell, int axis, const std::vector<std::uint32_t>& slots) {
    const float lo = cell.lo[axis], hi = cell.hi[axis];
    switch (rng_.next_below(6)) {
      case 0:
        return next_up(lo);
      case 1:
        return next_down(hi);
      case 2:
        return lo + (hi - lo) * 0.5f;
      case 3:
        return lo + (hi - lo) * rng_.next_float();
      default: {
        if (slots.empty()) return static_cast<float>(rng_.next_below(5)) * 0.25f;
        const PackedTriangle& t = triangles_[slots[rng_.next_below(static_cast<std::uint32_t>(slots.size()))]];
        return t.vertex(static_cast<int>(rng_.next_below(3)))[axis];
      }
    }
  }

  RandomKdTreeOptions options_;
  CounterRng rng_;
  std::vector<PackedTriangle> triangles_;
  std::vector<Aabb> boxes_;  // of the triangles, padded
  std::vector<KdNode> nodes_;
  std::vector<std::uint32_t> references_;
  std::uint32_t depth_ = 0, leaf_count_ = 0;
};

}  // namespace

KdTree random_kdtree(const TriangleMesh& mesh, std::uint64_t seed, const RandomKdTreeOptions& options) {
  return RandomKdTreeBuild(mesh, seed, options).run();
}

}  // namespace accel::validation
