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
        active_(leaves + kPadding),
        next_(leaves + kPadding),
        partner_(leaves) {
    for_chunks(0, leaves, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) active_[i] = make_cluster(clusters[i].box(), static_cast<std::uint32_t>(i), 0);
    });
    pad();
  }
  std::size_t count() const { return count_; }
  std::size_t size_bytes() const { return active_.size_bytes() + next_.size_bytes() + partner_.size_bytes(); }

  // Of more than one cluster.
  void round() {
    std::vector<Sums> sums(chunk_count(count_));
    for_chunks(0, count_, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      for (std::size_t first = begin; first < end; first += kBlock) find_pairs(first, std::min(first + kBlock, end));
      sums[chunk] = count_pairs(begin, end);
    });
    if (add_up(sums) * kLeastShare < count_) pair_neighbours(sums);
    for_chunks(0, count_, [&](std::size_t chunk, std::size_t begin, std::size_t end) { merge(begin, end, sums[chunk]); });
    const std::size_t merged = sums.back().pairs_here + sums.back().pairs_before;
    count_ -= merged, nodes_ += merged;
    std::swap(active_, next_);
    pad();
  }

 private:
  static_assert(kReach == 2, "find_pairs() looks at two neighbours on each side");
  static constexpr std::size_t kBlock = 512;  // clusters that look for partners at once
  static constexpr std::size_t kPadding = 3;  // behind the clusters there are some to look at, which become nobody's partner

  struct Sums {
    std::size_t pairs_here = 0, kept_here = 0, pairs_before = 0, kept_before = 0;
  };

  void pad() { std::fill_n(active_.data() + count_, kPadding, Cluster{}); }

  static PairKey key(float area, std::size_t i, std::size_t j) {
    return PairKey{std::bit_cast<std::uint32_t>(area)} << 32 | (i ^ j);
  }

  // The keys of pairs: of each cluster with the next, and with the one behind that. In the arrays cluster `begin` has number 4.
  struct Pairs {
    PairKey next[kBlock + 8], second[kBlock + 8];
  };

  // Those that concern [begin - 2, end + 2).
  void find_keys(std::size_t begin, std::size_t end, Pairs& pairs) const {
    const std::size_t first = begin - std::min<std::size_t>(begin, 4), last = std::min(count_, end + 2);
    std::fill_n(pairs.next, 4, kNoPair), std::fill_n(pairs.second, 4, kNoPair);
    Box4 a = active_[first].box(), b = active_[first + 1].box();
    for (std::size_t i = first; i < last; i += 2) {
      const Box4 c = active_[i + 2].box(), d = active_[i + 3].box();
      const Float4 lo[4] = {min_of(a.lo, b.lo), min_of(a.lo, c.lo), min_of(b.lo, c.lo), min_of(b.lo, d.lo)};
      const Float4 hi[4] = {max_of(a.hi, b.hi), max_of(a.hi, c.hi), max_of(b.hi, c.hi), max_of(b.hi, d.hi)};
      float area[4];
      half_areas(lo, hi, scale_, area);
      const std::size_t at = i + 4 - begin;
      pairs.next[at] = key(area[0], i, i + 1), pairs.second[at] = key(area[1], i, i + 2);
      pairs.next[at + 1] = key(area[2], i + 1, i + 2), pairs.second[at + 1] = key(area[3], i + 1, i + 3);
      a = c, b = d;
    }
    if (last < count_) return;
    pairs.next[count_ + 3 - begin] = kNoPair;
    for (std::size_t i = count_ + 2 - begin; i < count_ + 4 - begin; ++i) pairs.second[i] = kNoPair;
  }

  // partner_ of [begin, end): how far away it is, or 0. Two are partners if each has its least key with the other.
  void find_pairs(std::size_t begin, std::size_t end) {
    Pairs pairs;
    find_keys(begin, end, pairs);
    PairKey best[kBlock + 4];  // cluster `begin` has number 2
    const std::size_t first = begin - std::min<std::size_t>(begin, 2), last = std::min(count_, end + 2);
    const auto lesser = [](PairKey a, PairKey b) { return a < b ? a : b; };  // by value: std::min() chooses addresses
    for (std::size_t i = first + 4 - begin; i < last + 4 - begin; ++i)
      best[i - 2] = lesser(lesser(pairs.next[i - 1], pairs.next[i]), lesser(pairs.second[i - 2], pairs.second[i]));
    for (std::size_t i = begin; i < end; ++i) {
      const PairKey least = best[i + 2 - begin];
      const std::size_t other = i ^ difference(least);
      const int chosen = best[other + 2 - begin] == least ? -1 : 0;  // a mask: nobody can guess
      partner_[i] = static_cast<std::int8_t>(static_cast<int>(other - i) & chosen);
    }
  }

  void pair_neighbours(std::vector<Sums>& sums) {
    for_chunks(0, count_, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        partner_[i] = (i ^ 1) < count_ ? static_cast<std::int8_t>((i ^ 1) - i) : std::int8_t{0};
      sums[chunk] = count_pairs(begin, end);
    });
    add_up(sums);
  }

  Sums count_pairs(std::size_t begin, std::size_t end) const {
    std::size_t pairs = 0, seconds = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const int partner = partner_[i];  // its sign, without a branch
      pairs += static_cast<std::uint32_t>(-partner) >> 31, seconds += static_cast<std::uint32_t>(partner) >> 31;
    }
    return {pairs, end - begin - seconds};
  }
  static std::size_t add_up(std::vector<Sums>& sums) {
    std::size_t pairs = 0, kept = 0;
    for (Sums& sum : sums) {
      sum.pairs_before = pairs, pairs += sum.pairs_here;
      sum.kept_before = kept, kept += sum.kept_here;
    }
    return pairs;
  }

  // Without branches on what a cluster is, which nobody can guess: what is written in vain is overwritten by the next.
  void merge(std::size_t begin, std::size_t end, const Sums& sums) {
    std::size_t node = nodes_ + sums.pairs_before, to = sums.kept_before;
    const std::size_t last = to + sums.kept_here;
    Cluster nowhere;
    for (std::size_t i = begin; to < last; ++i) {
      ACCEL_ASSERT(i < end);
      const int partner = partner_[i];
      const Cluster &a = active_[i], &b = active_[i + static_cast<std::size_t>(std::max(partner, 0))];
      Box4 box = a.box();
      box.extend(b.box());
      *(partner > 0 ? &clusters_[node] : &nowhere) = make_cluster(box, a.first, b.first);
      next_[to] = make_cluster(box, partner > 0 ? static_cast<std::uint32_t>(node) : a.first, 0);
      node += partner > 0 ? 1 : 0, to += partner < 0 ? 0 : 1;
    }
    static_cast<void>(end);
  }

  Buffer<Cluster>& clusters_;
  std::size_t nodes_, count_;
  Float4 scale_;
  Buffer<Cluster> active_, next_;
  Buffer<std::int8_t> partner_;
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
