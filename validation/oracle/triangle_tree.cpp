#include "validation/oracle/triangle_tree.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <span>

#include "libaccel/core/float_bounds.h"
#include "validation/oracle/exact_predicates.h"

namespace accel::validation {
namespace {

// A box as Node and Reference keep it.
struct Box {
  float lo[3] = {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
                 std::numeric_limits<float>::infinity()};
  float hi[3] = {-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                 -std::numeric_limits<float>::infinity()};

  void extend(const float* other_lo, const float* other_hi) {
    for (int axis = 0; axis < 3; ++axis) {
      lo[axis] = std::min(lo[axis], other_lo[axis]), hi[axis] = std::max(hi[axis], other_hi[axis]);
    }
  }
  // In double: extents may be as large as 2^62.
  double half_area() const {
    const double x = double{hi[0]} - lo[0], y = double{hi[1]} - lo[1], z = double{hi[2]} - lo[2];
    return x < 0 ? 0 : x * y + y * z + z * x;
  }
};

// Extends a box by a placed vertex and what double may be wrong about it, rounded outwards.
void extend(float (&lo)[3], float (&hi)[3], const Affine& transform, Vec3 v) {
  const Vec3d p = transform_point(transform, Vec3d(v));
  const double at[3] = {p.x, p.y, p.z};
  for (int axis = 0; axis < 3; ++axis) {
    const double error = 4 * 0x1p-53 * placed_magnitude(transform, v, axis);
    lo[axis] = std::min(lo[axis], round_down(at[axis] - error)), hi[axis] = std::max(hi[axis], round_up(at[axis] + error));
  }
}

}  // namespace

class TriangleTree::Builder {
 public:
  static constexpr int kBins = 16;
  static constexpr std::size_t kLeafSize = 4;
  static constexpr std::size_t kParallelSize = 8192;
  // From here on nodes are halved: 2^32 triangles add 31 levels at most, and a path fits the traversal's stack.
  static constexpr int kHalvingDepth = 80;
  static constexpr int kMaxDepth = kHalvingDepth + 32;
  static_assert(kMaxDepth < kStackSize);

  Builder(std::vector<Reference>& references, std::vector<Node>& nodes) : references_(references), nodes_(nodes) {
    nodes_.resize(2 * references.size());
    next_node_ = 1;
    build(0, 0, references.size(), 0);
    nodes_.resize(next_node_);
    nodes_.shrink_to_fit();
  }

 private:
  static double centre(const Reference& r, int axis) { return 0.5 * r.lo[axis] + 0.5 * r.hi[axis]; }

  void build(std::uint32_t index, std::size_t begin, std::size_t end, int depth) {
    const std::span<Reference> range(references_.data() + begin, end - begin);
    Box box;
    for (const Reference& r : range) box.extend(r.lo, r.hi);
    Node& node = nodes_[index];
    std::copy(box.lo, box.lo + 3, node.lo), std::copy(box.hi, box.hi + 3, node.hi);
    if (range.size() <= kLeafSize) {
      node.first = static_cast<std::uint32_t>(begin), node.count = static_cast<std::uint32_t>(range.size());
      return;
    }

    const std::size_t middle = begin + split(range, depth);
    const std::uint32_t child = next_node_.fetch_add(2);
    node.first = child, node.count = 0;
    const auto left = [=, this] { build(child, begin, middle, depth + 1); };
    const auto right = [=, this] { build(child + 1, middle, end, depth + 1); };
    if (range.size() < kParallelSize) {
      left(), right();
    } else {
      tbb::parallel_invoke(left, right);
    }
  }

  // Partitions the references; returns how many come first, neither none nor all.
  static std::size_t split(std::span<Reference> range, int depth) {
    double lo[3], hi[3];
    for (int axis = 0; axis < 3; ++axis) {
      lo[axis] = hi[axis] = centre(range[0], axis);
      for (const Reference& r : range) {
        lo[axis] = std::min(lo[axis], centre(r, axis)), hi[axis] = std::max(hi[axis], centre(r, axis));
      }
    }
    int axis = 0;
    for (int other = 1; other < 3; ++other) axis = hi[other] - lo[other] > hi[axis] - lo[axis] ? other : axis;

    if (depth < kHalvingDepth && hi[axis] > lo[axis]) {
      const double scale = kBins / (hi[axis] - lo[axis]);
      const auto bin_of = [=](const Reference& r) {
        return std::clamp(static_cast<int>((centre(r, axis) - lo[axis]) * scale), 0, kBins - 1);
      };
      const int plane = best_plane(range, bin_of);
      const auto middle = std::partition(range.begin(), range.end(), [=](const Reference& r) { return bin_of(r) < plane; });
      const auto first = static_cast<std::size_t>(middle - range.begin());
      if (first > 0 && first < range.size()) return first;
    }
    const std::size_t half = range.size() / 2;
    std::nth_element(range.begin(), range.begin() + static_cast<std::ptrdiff_t>(half), range.end(),
                     [=](const Reference& a, const Reference& b) { return centre(a, axis) < centre(b, axis); });
    return half;
  }

  // The bin that starts the second side of the cheapest split by the surface-area heuristic.
  template <class BinOf>
  static int best_plane(std::span<const Reference> range, const BinOf& bin_of) {
    Box boxes[kBins];
    std::size_t counts[kBins] = {};
    for (const Reference& r : range) {
      const int bin = bin_of(r);
      boxes[bin].extend(r.lo, r.hi), ++counts[bin];
    }
    double cost_before[kBins] = {};  // of everything in front of a bin
    Box before;
    std::size_t count = 0;
    for (int bin = 1; bin < kBins; ++bin) {
      before.extend(boxes[bin - 1].lo, boxes[bin - 1].hi), count += counts[bin - 1];
      cost_before[bin] = before.half_area() * static_cast<double>(count);
    }
    int best = kBins / 2;
    double best_cost = std::numeric_limits<double>::infinity();
    Box after;
    count = 0;
    for (int bin = kBins - 1; bin > 0; --bin) {
      after.extend(boxes[bin].lo, boxes[bin].hi), count += counts[bin];
      const double cost = cost_before[bin] + after.half_area() * static_cast<double>(count);
      if (count > 0 && count < range.size() && cost < best_cost) best_cost = cost, best = bin;
    }
    return best;
  }

  std::vector<Reference>& references_;
  std::vector<Node>& nodes_;
  std::atomic<std::uint32_t> next_node_;
};

TriangleTree::TriangleTree(const TriangleMesh& mesh) {
  std::vector<Reference> references;
  references.reserve(mesh.size());
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    const Triangle t = mesh.triangle(i);
    if (!in_range(t.v0) || !in_range(t.v1) || !in_range(t.v2)) continue;
    const Aabb box = t.bounds();
    references.push_back({{box.lo.x, box.lo.y, box.lo.z}, {box.hi.x, box.hi.y, box.hi.z}, static_cast<std::uint32_t>(i)});
  }
  build(references);
}

TriangleTree::TriangleTree(const InstancedMeshes& scene) {
  std::vector<Reference> references;
  references.reserve(scene.size());
  for (std::size_t i = 0; i < scene.instances().size(); ++i) {
    const Instance& instance = scene.instances()[i];
    const TriangleMesh& mesh = scene.meshes()[instance.mesh];
    for (std::uint32_t n = 0; n < mesh.size(); ++n) {
      const Triangle t = mesh.triangle(n);
      if (!in_range(t.v0) || !in_range(t.v1) || !in_range(t.v2)) continue;
      Reference reference{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, scene.first_prim(i) + n};
      for (const Vec3 v : {t.v0, t.v1, t.v2}) extend(reference.lo, reference.hi, instance.transform, v);
      references.push_back(reference);
    }
  }
  build(references);
}

void TriangleTree::build(std::vector<Reference>& references) {
  if (references.empty()) return;
  Builder(references, nodes_);
  prims_.reserve(references.size());
  for (const Reference& r : references) prims_.push_back(r.prim_id);
}

}  // namespace accel::validation
