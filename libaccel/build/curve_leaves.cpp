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

constexpr std::size_t kWindow = 512;  // references that are cut at once: their boxes stay in the nearest cache

// Cuts a window of the curve.
class Window {
 public:
  Window(Float4 scale, std::uint32_t most) : scale_(scale), most_(most) {}

  // Adds the leaves of references [begin, end) to `out`; returns the end of that. Boxes are fetched first, and by a loop that
  // does nothing else, because most of them are far away.
  Cluster* cut(const References& references, const CurveOrder& order, std::size_t begin, std::size_t end, Cluster* out) {
    count_ = end - begin;
    for (std::size_t i = 0; i < count_; ++i) box_[i] = references.storage[order[begin + i]].box();
    prefetch(references, order, end);
    choose();
    for (std::size_t i = 0; i < count_; i += size_[i]) {
      const std::size_t size = size_[i];
      Box4 box = box_[i];
      for (std::size_t k = 1; k < kBlockLanes; ++k) box.extend(box_[k < size ? i + k : i]);  // no branch to guess
      *out++ = make_cluster(box, static_cast<std::uint32_t>(begin + i), static_cast<std::uint32_t>(size));
    }
    return out;
  }

 private:
  // The next window, while this one is cut.
  static void prefetch(const References& references, const CurveOrder& order, std::size_t begin) {
    const std::size_t end = std::min(begin + kWindow, order.size());
    for (std::size_t i = begin; i < end; ++i) __builtin_prefetch(&references.storage[order[i]]);
  }

  // size_[i] is that of the first leaf of the cheapest cut of [i, count_).
  void choose() {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    static_assert(kBlockLanes == 4);
    Box4 next[3];                                                        // of the references that follow
    float cost[4] = {0, kInfinity, kInfinity, kInfinity}, most[4] = {};  // of what is behind a leaf of k + 1
    for (std::uint32_t k = most_; k < 4; ++k) most[k] = kInfinity;
    const std::uint32_t last = most_ - 1;
    for (std::size_t i = count_; i-- > 0;) {
      Float4 lo[4], hi[4];
      Box4 sum = box_[i];
      const Box4 first = sum;
      for (int k = 0; k < 4; ++k) {
        lo[k] = sum.lo, hi[k] = sum.hi;
        if (k < 3) sum.extend(next[k]);
      }
      float area[4];
      half_areas(lo, hi, scale_, area);
      const float child = kChildCost * area[last];
      const float of_1 = area[0] + cost[0], of_2 = area[1] + cost[1] + most[1], of_3 = area[2] + cost[2] + most[2],
                  of_4 = area[3] + cost[3] + most[3];
      const float of_34 = min_of(of_4, of_3), of_234 = min_of(of_34, of_2), least = min_of(of_234, of_1);
      // In masks: nobody can guess them.
      const int past_1 = of_234 <= of_1 ? -1 : 0, past_2 = of_34 <= of_2 ? -1 : 0, past_3 = of_4 <= of_3 ? -1 : 0;
      size_[i] = static_cast<std::uint8_t>(1 - (past_1 & (-1 + (past_2 & (-1 + past_3)))));
      cost[3] = cost[2], cost[2] = cost[1], cost[1] = cost[0], cost[0] = least + child;
      next[2] = next[1], next[1] = next[0], next[0] = first;
    }
  }

  const Float4 scale_;
  const std::uint32_t most_;
  std::size_t count_ = 0;
  Box4 box_[kWindow];
  std::uint8_t size_[kWindow];
};

}  // namespace

ClusterTree cut_into_leaves(BuildContext& context, const References& references, const CurveOrder& order, std::uint32_t most) {
  context.begin_phase("leaves");
  const Float4 scale = unit_scale(references.bounds.boxes);
  std::vector<Buffer<Cluster>> leaves(chunk_count(order.size()));
  for_chunks(0, order.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    Window window(scale, most);
    Cluster found[kChunk], *last = found;
    for (std::size_t first = begin; first < end; first += kWindow)
      last = window.cut(references, order, first, std::min(first + kWindow, end), last);
    leaves[chunk] = Buffer<Cluster>::copy_of({found, last});
  });

  std::vector<std::size_t> first(leaves.size());
  std::size_t count = 0;
  for (std::size_t chunk = 0; chunk < leaves.size(); ++chunk) first[chunk] = std::exchange(count, count + leaves[chunk].size());
  ClusterTree tree{Buffer<Cluster>(2 * count - 1), count, {}};
  context.memory.add(tree.clusters.size_bytes());
  const std::size_t parts = count * sizeof(Cluster);  // which live as long as this function
  context.memory.add(parts), context.memory.subtract(parts);
  tbb::parallel_for(std::size_t{0}, leaves.size(), [&](std::size_t chunk) {
    std::copy(leaves[chunk].begin(), leaves[chunk].end(), tree.clusters.data() + first[chunk]);
  });
  return tree;
}

}  // namespace accel
