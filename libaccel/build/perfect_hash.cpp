#include "libaccel/build/perfect_hash.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include <tbb/parallel_for.h>

#include "libaccel/build/parallel.h"

namespace accel {
namespace {

constexpr int kMaxGrowths = 128;            // of H by 2, for one multiplier
constexpr std::uint32_t kMaxAttempts = 16;  // multipliers
constexpr std::uint32_t kEmpty = kNoNode;

// Keys by bucket, in one array, sorted within each bucket; buckets by decreasing size.
struct Buckets {
  std::vector<HashedNode> keys;
  std::vector<std::uint32_t> begin;    // by bucket, and the end of the last
  std::vector<std::uint32_t> by_size;  // bucket numbers
  std::vector<std::uint32_t> of_size;  // [s]: how many have at least s + 1 keys, for s = 0, 1, ..., and 0 at last

  std::span<const HashedNode> of(std::uint32_t bucket) const {
    return {keys.data() + begin[bucket], begin[bucket + 1] - begin[bucket]};
  }
  std::uint32_t size(std::uint32_t bucket) const { return begin[bucket + 1] - begin[bucket]; }
};

template <class Body>
void for_indices(std::size_t count, const Body& body) {
  for_chunks(0, count, [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) body(i);
  });
}

// Counting sort: by bucket, and by size.
template <class Key>
Buckets make_buckets(const std::vector<HashedNode>& nodes, const NodeHashView& hash) {
  const std::size_t count = std::size_t{1} << hash.log2_of_buckets;
  const auto bucket_of = [&](const HashedNode& node) { return hash.bucket(static_cast<Key>(node.key)); };
  std::unique_ptr<std::atomic<std::uint32_t>[]> next(new std::atomic<std::uint32_t>[count]());
  for_indices(nodes.size(), [&](std::size_t i) { next[bucket_of(nodes[i])].fetch_add(1, std::memory_order_relaxed); });

  Buckets buckets;
  buckets.begin.resize(count + 1);
  for (std::size_t b = 0; b < count; ++b) {
    buckets.begin[b + 1] = buckets.begin[b] + next[b];
    next[b] = buckets.begin[b];
  }
  buckets.keys.resize(nodes.size());
  for_indices(nodes.size(), [&](std::size_t i) {
    buckets.keys[next[bucket_of(nodes[i])].fetch_add(1, std::memory_order_relaxed)] = nodes[i];
  });
  for_indices(count, [&](std::size_t b) {
    std::sort(buckets.keys.begin() + buckets.begin[b], buckets.keys.begin() + buckets.begin[b + 1],
              [](const HashedNode& x, const HashedNode& y) { return x.key < y.key; });
  });

  for (std::uint32_t b = 0; b < count; ++b)
    if (buckets.size(b) > buckets.of_size.size()) buckets.of_size.resize(buckets.size(b));
  for (std::uint32_t b = 0; b < count; ++b)
    if (buckets.size(b) > 0) ++buckets.of_size[buckets.size(b) - 1];
  buckets.of_size.push_back(0);
  for (std::size_t s = buckets.of_size.size() - 1; s-- > 0;) buckets.of_size[s] += buckets.of_size[s + 1];
  buckets.by_size.resize(buckets.of_size[0]);
  std::vector<std::uint32_t> place(buckets.of_size.begin() + 1, buckets.of_size.end());
  for (std::uint32_t b = 0; b < count; ++b)
    if (buckets.size(b) > 0) buckets.by_size[place[buckets.size(b) - 1]++] = b;
  return buckets;
}

bool needs_no_slot(std::span<const HashedNode> bucket) { return bucket.size() == 1 && fits_direct(bucket[0].ref); }

bool has_equal_keys(const Buckets& buckets) {
  std::atomic<bool> found = false;
  for_indices(buckets.by_size.size(), [&](std::size_t i) {
    const auto keys = buckets.of(buckets.by_size[i]);
    for (std::size_t k = 1; k < keys.size(); ++k)
      if (keys[k].key == keys[k - 1].key) found = true;
  });
  return found;
}

template <class Key>
bool has_unseparable_keys(const Buckets& buckets, const NodeHashView& hash) {
  std::atomic<bool> found = false;
  for_indices(buckets.by_size.size(), [&](std::size_t i) {
    const auto keys = buckets.of(buckets.by_size[i]);
    for (std::size_t k = 1; k < keys.size() && !found; ++k)
      for (std::size_t j = 0; j < k; ++j)
        if (hash.residue(static_cast<Key>(keys[k].key)) == hash.residue(static_cast<Key>(keys[j].key))) found = true;
  });
  return found;
}

// Fills the slots, one size of buckets after the other.
template <class Key>
class SlotPlacement {
 public:
  SlotPlacement(const Buckets& buckets, const NodeHashView& hash, PerfectHash& out)
      : buckets_(buckets), hash_(hash), out_(out), claims_(new std::atomic<std::uint32_t>[hash.slot_count]) {
    for_indices(hash.slot_count, [&](std::size_t s) { claims_[s].store(kEmpty, std::memory_order_relaxed); });
  }

  // False if a bucket finds no displacement.
  bool run() {
    for (std::size_t size = buckets_.of_size.size() - 1; size-- > 0;) {
      std::vector<Seeker> seekers;
      for (std::uint32_t i = buckets_.of_size[size + 1]; i < buckets_.of_size[size]; ++i) add(i, seekers);
      while (!seekers.empty())
        if (!round(seekers)) return false;
    }
    return true;
  }

 private:
  // A bucket by its place in the order, the displacement that it tries next, and how many it has tried.
  struct Seeker {
    std::uint32_t rank, displacement, tried;
    bool has_lost;
  };

  // Where a bucket starts to look. Keys of a tree's full levels are dense: were all buckets to start at 0, they would fill the
  // table run by run, and each would have to search through what the ones before it have filled.
  std::uint32_t first_displacement(std::uint32_t bucket) const { return multiply_high(bucket * 0x9e3779b9u, hash_.slot_count); }

  std::span<const HashedNode> keys(const Seeker& s) const { return buckets_.of(buckets_.by_size[s.rank]); }
  std::uint32_t slot(const HashedNode& node, const Seeker& s) const {
    return hash_.slot(static_cast<Key>(node.key), s.displacement);
  }

  void add(std::uint32_t rank, std::vector<Seeker>& seekers) {
    const std::uint32_t bucket = buckets_.by_size[rank];
    const auto nodes = buckets_.of(bucket);
    if (!needs_no_slot(nodes)) return seekers.push_back({rank, first_displacement(bucket), 0, false});
    out_.displacements[bucket] = direct_entry(nodes[0].ref);
    ++out_.direct;
  }

  // All seekers look for free slots and claim them; those who keep all their claims are done.
  bool round(std::vector<Seeker>& seekers) {
    std::atomic<bool> failed = false;
    for_indices(seekers.size(), [&](std::size_t i) {
      if (!seek(seekers[i])) failed = true;
    });
    if (failed) return false;
    for_indices(seekers.size(), [&](std::size_t i) { claim(seekers[i]); });
    for_indices(seekers.size(), [&](std::size_t i) { seekers[i].has_lost = !keeps_claims(seekers[i]); });
    for_indices(seekers.size(), [&](std::size_t i) { settle(seekers[i]); });
    std::erase_if(seekers, [](const Seeker& s) { return !s.has_lost; });
    return true;
  }

  bool seek(Seeker& s) const {
    const auto is_free = [&](const HashedNode& node) { return out_.slots[slot(node, s)] == kEmpty; };
    const auto nodes = keys(s);
    for (; s.tried < hash_.slot_count; ++s.tried) {
      if (std::all_of(nodes.begin(), nodes.end(), is_free) && are_apart(s)) return true;
      if (++s.displacement == hash_.slot_count) s.displacement = 0;
    }
    return false;
  }

  // The keys of a bucket have different residues, but k + d may wrap for some of them only.
  bool are_apart(const Seeker& s) const {
    const auto nodes = keys(s);
    for (std::size_t k = 1; k < nodes.size(); ++k)
      for (std::size_t j = 0; j < k; ++j)
        if (slot(nodes[k], s) == slot(nodes[j], s)) return false;
    return true;
  }

  // The lowest rank gets a slot.
  void claim(const Seeker& s) {
    for (const HashedNode& node : keys(s)) {
      std::atomic<std::uint32_t>& holder = claims_[slot(node, s)];
      std::uint32_t other = holder.load(std::memory_order_relaxed);
      while (s.rank < other && !holder.compare_exchange_weak(other, s.rank, std::memory_order_relaxed)) {
      }
    }
  }

  bool keeps_claims(const Seeker& s) const {
    const auto nodes = keys(s);
    return std::all_of(nodes.begin(), nodes.end(), [&](const HashedNode& node) {
      return claims_[slot(node, s)].load(std::memory_order_relaxed) == s.rank;
    });
  }

  // Winners fill their slots; losers let go.
  void settle(const Seeker& s) {
    for (const HashedNode& node : keys(s)) {
      const std::uint32_t at = slot(node, s);
      std::uint32_t self = s.rank;
      if (s.has_lost)
        claims_[at].compare_exchange_strong(self, kEmpty, std::memory_order_relaxed);
      else
        out_.slots[at] = node.ref;
    }
    if (!s.has_lost) out_.displacements[buckets_.by_size[s.rank]] = s.displacement;
  }

  const Buckets& buckets_;
  const NodeHashView& hash_;
  PerfectHash& out_;
  std::unique_ptr<std::atomic<std::uint32_t>[]> claims_;  // by slot: the lowest rank that wants it
};

template <class Key>
bool place(const Buckets& buckets, const NodeHashView& hash, PerfectHash& out) {
  out.displacements = Buffer<std::uint32_t>(std::size_t{1} << hash.log2_of_buckets);
  out.slots = Buffer<NodeRef>(hash.slot_count);
  out.direct = 0;
  std::fill(out.displacements.begin(), out.displacements.end(), 0u);
  std::fill(out.slots.begin(), out.slots.end(), kEmpty);
  return SlotPlacement<Key>(buckets, hash, out).run();
}

// Keys that need a slot.
std::size_t count_placed(const Buckets& buckets) {
  const auto direct = std::count_if(buckets.by_size.begin(), buckets.by_size.end(),
                                    [&](std::uint32_t b) { return needs_no_slot(buckets.of(b)); });
  return buckets.keys.size() - static_cast<std::size_t>(direct);
}

std::uint32_t odd(double x) { return static_cast<std::uint32_t>(std::ceil(x)) | 1u; }

template <class Key>
void resize(NodeHashView& hash, std::uint32_t slot_count) {
  hash.slot_count = slot_count, hash.reciprocal = reciprocal_of<Key>(slot_count);
}

// One attempt: with growing H, until the keys of all buckets can be separated.
template <class Key>
bool try_multiplier(const Buckets& buckets, NodeHashView& hash, PerfectHash& out) {
  for (int growth = 0; growth < kMaxGrowths; ++growth, ++out.retries) {
    if (!has_unseparable_keys<Key>(buckets, hash)) return place<Key>(buckets, hash, out);
    resize<Key>(hash, hash.slot_count + 2);
  }
  return false;
}

template <class Key>
Result<PerfectHash> make(const std::function<std::vector<HashedNode>(std::uint64_t)>& keys_for) {
  PerfectHash out;
  double spare = kSlotsPerKey;
  for (std::uint32_t attempt = 0; attempt < kMaxAttempts; ++attempt, ++out.retries, spare *= 1.25) {
    NodeHashView hash;
    out.multiplier = hash.multiplier = hash_multiplier(attempt);
    const std::vector<HashedNode> nodes = keys_for(hash.multiplier);
    if (nodes.empty()) return out;
    if (nodes.size() >= kDirectBit / 8) return Error{"there are too many nodes to be hashed: " + std::to_string(nodes.size())};
    hash.log2_of_buckets = static_cast<std::uint32_t>(std::bit_width(std::max<std::size_t>(nodes.size() / 2, 2)) - 1);
    const Buckets buckets = make_buckets<Key>(nodes, hash);
    if (has_equal_keys(buckets)) continue;
    resize<Key>(hash, odd(spare * static_cast<double>(count_placed(buckets))));
    if (try_multiplier<Key>(buckets, hash, out)) return out;
  }
  return Error{"no hash tables were found that separate the keys of all nodes, in " + std::to_string(out.retries) +
               " attempts; build the tree with a smaller max_depth"};
}

}  // namespace

std::uint64_t hash_multiplier(std::uint32_t attempt) {
  return (0x9e3779b97f4a7c15u + std::uint64_t{attempt} * 0xd1342543de82ef94u) | (std::uint64_t{1} << 32) | 1u;
}

Result<PerfectHash> make_perfect_hash(const std::function<std::vector<HashedNode>(std::uint64_t)>& keys_for, bool narrow_keys) {
  return narrow_keys ? make<std::uint32_t>(keys_for) : make<std::uint64_t>(keys_for);
}

}  // namespace accel
