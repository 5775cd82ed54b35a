#include "libaccel/build/curve_leaves.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "libaccel/build/parallel.h"
#include "libaccel/build/sah_bins.h"
#include "libaccel/structure/triangle_block.h"

namespace accel {
namespace {

// What a child costs beside its own test, in areas of a full leaf nearby: eight children share a step through their parent,
// whose box is some eight times as large.
constexpr float kChildCost = 1.0f;

// The cheapest cut of references[begin, end).
class Cutter {
 public:
  Cutter(const Reference* references, std::size_t begin, std::size_t end, Float4 scale, std::uint32_t most)
      : references_(references + begin),
        first_(static_cast<std::uint32_t>(begin)),
        count_(end - begin),
        most_(most),
        scale_(scale),
        cost_(count_ + 1),
        size_(count_ + 1) {
    cut();
  }

  // Writes the leaves; returns how many.
  std::size_t write(Cluster* out) const {
    std::size_t leaves = 0;
    for (std::size_t end = count_; end > 0; end -= size_[end]) ++leaves;
    std::size_t next = leaves;
    for (std::size_t end = count_; end > 0; end -= size_[end]) {
      const std::size_t begin = end - size_[end];
      Box4 box;
      for (std::size_t i = begin; i < end; ++i) box.extend(references_[i].box());
      out[--next] = make_cluster(box, first_ + static_cast<std::uint32_t>(begin), size_[end]);
    }
    return leaves;
  }

 private:
  // cost_[i] is that of the first i references; size_[i] is that of their last leaf.
  void cut() {
    cost_[0] = 0;
    for (std::size_t end = 1; end <= count_; ++end) {
      const std::size_t longest = std::min<std::size_t>(most_, end);
      float area[kBlockLanes];
      Box4 box;
      for (std::size_t k = 1; k <= longest; ++k) box.extend(references_[end - k].box()), area[k - 1] = box.half_area(scale_);
      const float child = kChildCost * area[longest - 1];
      cost_[end] = std::numeric_limits<float>::infinity(), size_[end] = 1;
      for (std::size_t k = 1; k <= longest; ++k)
        if (const float cost = cost_[end - k] + area[k - 1] + child; !(cost > cost_[end]))
          cost_[end] = cost, size_[end] = static_cast<std::uint8_t>(k);
    }
  }

  const Reference* references_;
  std::uint32_t first_;
  std::size_t count_;
  std::uint32_t most_;
  Float4 scale_;
  std::vector<float> cost_;
  std::vector<std::uint8_t> size_;
};

}  // namespace

ClusterTree cut_into_leaves(BuildContext& context, const Buffer<Reference>& sorted, const Box4& bounds, std::uint32_t most) {
  context.begin_phase("leaves");
  const Float4 scale = unit_scale(bounds);
  ClusterTree tree{Buffer<Cluster>(2 * sorted.size()), 0, {}};
  context.memory.add(tree.clusters.size_bytes());
  std::vector<std::size_t> counts(chunk_count(sorted.size()));
  Cluster* const clusters = tree.clusters.data();
  for_chunks(0, sorted.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    counts[chunk] = Cutter(sorted.data(), begin, end, scale, most).write(clusters + begin);
  });
  for (std::size_t chunk = 0; chunk < counts.size(); ++chunk) {
    const Cluster* const from = clusters + chunk * kChunk;
    if (from != clusters + tree.leaves) std::copy(from, from + counts[chunk], clusters + tree.leaves);
    tree.leaves += counts[chunk];
  }
  return tree;
}

}  // namespace accel
