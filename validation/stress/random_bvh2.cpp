#include "validation/stress/random_bvh2.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/geometry/mesh_facts.h"

namespace accel::validation {
namespace {

class RandomBvh2Build {
 public:
  RandomBvh2Build(const TriangleMesh& mesh, std::uint64_t seed, const RandomBvh2Options& options)
      : mesh_(mesh), options_(options), rng_(seed, 0) {
    for (std::uint32_t i = 0; i < mesh.size(); ++i)
      if (is_in_range(mesh.triangle(i)) && !is_zero_area(mesh.triangle(i))) ids_.push_back(i);
    axis_ = static_cast<int>(rng_.next_below(4));
    if (axis_ < 3)  // else in the order of the mesh
      std::stable_sort(ids_.begin(), ids_.end(), [&](std::uint32_t a, std::uint32_t b) {
        return mesh.triangle(a).v0[axis_] < mesh.triangle(b).v0[axis_];
      });
  }

  Bvh2 run() {
    Bvh2 bvh;
    if (ids_.empty()) return bvh;
    bvh.root = make(0, static_cast<std::uint32_t>(ids_.size()), 0, bvh.bounds);
    bvh.nodes = Buffer<Bvh2Node>::copy_of(nodes_);
    bvh.leaves = Buffer<LeafQuad>::copy_of(quads_);
    bvh.depth = depth_, bvh.references = ids_.size();
    return bvh;
  }

 private:
  NodeRef make(std::uint32_t begin, std::uint32_t end, std::uint32_t level, Aabb& box) {
    const std::uint32_t count = end - begin;
    if (count == 1 || level >= options_.max_depth || (count <= options_.leaf_size && rng_.next_below(3) != 0))
      return make_leaf(begin, end, level, box);
    const auto index = static_cast<NodeRef>(nodes_.size());
    nodes_.emplace_back();
    const std::uint32_t middle = begin + size_of_first(count, level);
    Bvh2Node node{};
    Aabb boxes[2];
    node.child[0] = make(begin, middle, level + 1, boxes[0]);
    node.child[1] = make(middle, end, level + 1, boxes[1]);
    for (int c = 0; c < 2; ++c) {
      box.extend(boxes[c]);
      node.set_bounds(c, boxes[c]);
    }
    nodes_[index] = node;
    if (rng_.next_below(8) == 0) box.hi = box.hi + Vec3{0.25f, 0.0f, 0.125f};  // too large
    return index;
  }

  NodeRef make_leaf(std::uint32_t begin, std::uint32_t end, std::uint32_t level, Aabb& box) {
    const auto quad = static_cast<std::uint32_t>(quads_.size());
    for (std::uint32_t i = begin; i < end; ++i) {
      box.extend(mesh_.triangle(ids_[i]).bounds());
      const PackedTriangle packed = pack(mesh_.triangle(ids_[i]), ids_[i]);
      quads_.resize(quads_.size() + kQuadsPerTriangle);
      std::memcpy(&quads_[quads_.size() - kQuadsPerTriangle], &packed, sizeof packed);
    }
    quads_.push_back({{0, 0, 0}, kEndOfLeaf});
    depth_ = std::max(depth_, level);
    return leaf_ref(quad);
  }

  std::uint32_t size_of_first(std::uint32_t count, std::uint32_t level) {
    switch (options_.shape) {
      case TreeShape::balanced:
        return count / 2;
      case TreeShape::random:
        return 1 + rng_.next_below(count - 1);
      case TreeShape::skewed:
        return rng_.next_below(4) == 0 ? 1 + rng_.next_below(count - 1) : 1;
      case TreeShape::left_comb:
        return count - 1;
      case TreeShape::right_comb:
        return 1;
      case TreeShape::chain:
        return rng_.next_below(2) == 0 ? 1 : count - 1;
      case TreeShape::zigzag:
        break;
    }
    return level % 2 == 0 ? 1 : count - 1;
  }

  const TriangleMesh& mesh_;
  RandomBvh2Options options_;
  CounterRng rng_;
  int axis_;
  std::vector<std::uint32_t> ids_;
  std::vector<Bvh2Node> nodes_;
  std::vector<LeafQuad> quads_;
  std::uint32_t depth_ = 0;
};

}  // namespace

Bvh2 random_bvh2(const TriangleMesh& mesh, std::uint64_t seed, const RandomBvh2Options& options) {
  return RandomBvh2Build(mesh, seed, options).run();
}

}  // namespace accel::validation
