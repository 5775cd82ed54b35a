#include "libaccel/build/cluster_tree.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>
#include <vector>

#include "libaccel/build/parallel.h"
#include "libaccel/build/sah_bins.h"

namespace accel {
namespace {

// A round must merge one in kLeastShare, or it merges neighbours.
constexpr std::size_t kLeastShare = 8;

// The area of a pair's box, and behind it the exclusive or of their places: in this order a cluster's best partner is unique.
using PairKey = std::uint64_t;
constexpr PairKey kNoPair = std::numeric_limits<PairKey>::max();
std::uint32_t difference(PairKey key) { return static_cast<std::uint32_t>(key); }

// Clusters that are still without a parent, in the order of the curve: boxes, and in `first` their index.
class Merge {
 public:
  Merge(Buffer<Cluster>& clusters, std::size_t leaves, const Box4& bounds)
      : clusters_(clusters),
        nodes_(leaves),
        count_(leaves),
        scale_(unit_scale(bounds)),
        active_(leaves),
        next_(leaves),
        best_(leaves) {
    for_chunks(0, leaves, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) active_[i] = {clusters[i].lo, static_cast<std::uint32_t>(i), clusters[i].hi, 0};
    });
  }
  std::size_t count() const { return count_; }
  std::size_t size_bytes() const { return active_.size_bytes() + next_.size_bytes() + best_.size_bytes(); }

  void round() {
    for_chunks(0, count_, [&](std::size_t, std::size_t begin, std::size_t end) { find_partners(begin, end); });
    std::vector<Sums> sums(chunk_count(count_));
    if (count_pairs(sums) * kLeastShare < count_) pair_neighbours(), count_pairs(sums);
    for_chunks(0, count_, [&](std::size_t chunk, std::size_t begin, std::size_t end) { merge(begin, end, sums[chunk]); });
    const std::size_t merged = sums.back().pairs_here + sums.back().pairs_before;
    count_ -= merged, nodes_ += merged;
    std::swap(active_, next_);
  }

 private:
  struct Sums {
    std::size_t pairs_here = 0, pairs_before = 0, kept_before = 0;
  };

  PairKey key(std::size_t i, const Box4& a, std::size_t j) const {
    Box4 box = active_[j].box();
    box.extend(a);
    return PairKey{std::bit_cast<std::uint32_t>(box.half_area(scale_))} << 32 | (i ^ j);
  }

  // best_ of [begin, end). Every pair within it is looked at once.
  void find_partners(std::size_t begin, std::size_t end) {
    std::fill(best_.data() + begin, best_.data() + end, kNoPair);
    for (std::size_t i = begin - std::min<std::size_t>(begin, kReach); i < begin; ++i) {
      const Box4 box = active_[i].box();
      for (std::size_t j = begin; j < std::min(end, i + kReach + 1); ++j) best_[j] = std::min(best_[j], key(i, box, j));
    }
    for (std::size_t i = begin; i < end; ++i) {
      const Box4 box = active_[i].box();
      const std::size_t last = std::min(count_, i + kReach + 1), own = std::min(last, end);
      PairKey least = best_[i];
      for (std::size_t j = i + 1; j < own; ++j) {
        const PairKey pair = key(i, box, j);
        least = std::min(least, pair), best_[j] = std::min(best_[j], pair);
      }
      for (std::size_t j = std::max(i + 1, own); j < last; ++j) least = std::min(least, key(i, box, j));
      best_[i] = least;
    }
  }

  void pair_neighbours() {
    for (std::size_t i = 0; i < count_; ++i) best_[i] = (i ^ 1) < count_ ? 1 : kNoPair;
  }

  // Whether i and its partner have chosen each other: a key tells both.
  bool is_mutual(std::size_t i) const { return best_[i] != kNoPair && best_[i ^ difference(best_[i])] == best_[i]; }

  std::size_t count_pairs(std::vector<Sums>& sums) const {
    for_chunks(0, count_, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      std::size_t pairs = 0, seconds = 0;
      for (std::size_t i = begin; i < end; ++i)
        if (is_mutual(i)) (i ^ difference(best_[i])) > i ? ++pairs : ++seconds;
      sums[chunk] = {pairs, 0, end - begin - seconds};
    });
    std::size_t pairs = 0, kept = 0;
    for (Sums& sum : sums) {
      sum.pairs_before = pairs, pairs += sum.pairs_here;
      kept += std::exchange(sum.kept_before, kept);
    }
    return pairs;
  }

  void merge(std::size_t begin, std::size_t end, const Sums& sums) {
    std::size_t node = nodes_ + sums.pairs_before, to = sums.kept_before;
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_mutual(i)) {
        next_[to++] = active_[i];
        continue;
      }
      const std::size_t j = i ^ difference(best_[i]);
      if (j < i) continue;
      Box4 box = active_[i].box();
      box.extend(active_[j].box());
      clusters_[node] = make_cluster(box, active_[i].first, active_[j].first);
      next_[to++] = make_cluster(box, static_cast<std::uint32_t>(node++), 0);
    }
  }

  Buffer<Cluster>& clusters_;
  std::size_t nodes_, count_;
  Float4 scale_;
  Buffer<Cluster> active_, next_;
  Buffer<PairKey> best_;
};

}  // namespace

void merge_clusters(BuildContext& context, ClusterTree& tree, const Box4& bounds, ProgressMeter& progress) {
  context.begin_phase("merge");
  Merge merge(tree.clusters, tree.leaves, bounds);
  context.memory.add(merge.size_bytes());
  tree.rounds = {tree.leaves};
  while (merge.count() > 1 && !progress.stopped()) {
    const std::size_t before = merge.count();
    merge.round();
    tree.rounds.push_back(tree.rounds.back() + before - merge.count());
    progress.advance(before - merge.count());
  }
  context.memory.subtract(merge.size_bytes());
}

}  // namespace accel
