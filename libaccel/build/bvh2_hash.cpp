#include "libaccel/build/bvh2_hash.h"

#include <cstdio>
#include <string>
#include <vector>

#include "libaccel/build/bvh2_walk_parallel.h"
#include "libaccel/build/parallel.h"
#include "libaccel/build/perfect_hash.h"

namespace accel {
namespace {

// Keys of all inner nodes.
std::vector<NodeKey> node_keys(const Bvh2& bvh, std::uint64_t multiplier) {
  std::vector<NodeKey> keys(bvh.nodes.size());
  walk_bvh2_parallel(bvh.view(), {.ref = bvh.root}, multiplier, [&](const Bvh2Place& place) {
    if (!is_leaf(place.ref)) keys[place.ref] = place.key;
  });
  return keys;
}

bool is_hashed(const Bvh2& bvh, NodeRef sibling, HashedKeys which) {
  return which == HashedKeys::all || has_inner_node_below(bvh.nodes.data(), sibling, kHashedDistance);
}

// The children of the nodes [begin, end) that are to be hashed.
std::vector<HashedNode> hashed_children(const Bvh2& bvh, HashedKeys which, std::uint64_t multiplier,
                                        const std::vector<NodeKey>& keys, std::size_t begin, std::size_t end) {
  std::vector<HashedNode> result;
  for (std::size_t i = begin; i < end; ++i) {
    const NodeRef* const child = bvh.nodes[i].child;
    for (const std::uint32_t side : {0u, 1u})
      if (is_hashed(bvh, child[side ^ 1u], which)) result.push_back({keys[i].child(side, multiplier).hashed(), child[side]});
  }
  return result;
}

std::vector<HashedNode> hashed_nodes(const Bvh2& bvh, HashedKeys which, std::uint64_t multiplier) {
  const std::vector<NodeKey> keys = node_keys(bvh, multiplier);
  std::vector<std::vector<HashedNode>> parts(chunk_count(bvh.nodes.size()));
  for_each_chunk(0, bvh.nodes.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    parts[chunk] = hashed_children(bvh, which, multiplier, keys, begin, end);
  });
  std::vector<HashedNode> all;
  for (const std::vector<HashedNode>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::string percent_of(std::size_t part, std::size_t whole) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f %%", whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0);
  return text;
}

void note_keys(const Bvh2& bvh, std::uint64_t hashed, BuildReport& report) {
  const std::uint64_t keys = 2 * bvh.nodes.size();
  if (bvh.hashed == HashedKeys::looked_up && hashed < keys)
    report.notes.push_back({"hash entries", "skipped for " + std::to_string(keys - hashed) + " of " + std::to_string(keys) +
                                                " nodes, because no inner node lies three levels below their siblings: they "
                                                "are found by links"});
  if (hashed == 0) {
    report.notes.push_back({"hash tables", "skipped, because no key can be looked up in this tree"});
    return;
  }
  if (bvh.depth <= kMaxDepth32)
    report.notes.push_back({"64-bit keys", "skipped, because the tree has depth " + std::to_string(bvh.depth) +
                                               " and 32 bits reach to " + std::to_string(kMaxDepth32)});
  else if (bvh.depth <= kMaxDepth64)
    report.notes.push_back({"64-bit keys", "chosen, because the tree has depth " + std::to_string(bvh.depth) +
                                               " and 32 bits reach to " + std::to_string(kMaxDepth32)});
  else
    report.notes.push_back({"keys with overflow", "chosen, because the tree has depth " + std::to_string(bvh.depth) +
                                                      " and 64 bits reach to " + std::to_string(kMaxDepth64)});
}

void note_tables(const Bvh2& bvh, const PerfectHash& hash, std::uint64_t hashed, BuildReport& report) {
  const std::size_t bytes = bvh.displacements.size_bytes() + bvh.slots.size_bytes();
  report.notes.push_back({"hash tables", std::to_string(hashed) + " keys in D = " + std::to_string(bvh.displacements.size()) +
                                             " displacements (" + std::to_string(hash.direct) +
                                             " of them references) and H = " + std::to_string(bvh.slots.size()) +
                                             " slots, after " + std::to_string(hash.retries) +
                                             " retries: " + percent_of(bytes, bvh.size_bytes() - bytes) + " more memory"});
}

}  // namespace

Status add_hash(Bvh2& bvh, HashedKeys which, BuildReport& report) {
  if (bvh.root == kNoNode) return Done{};
  std::uint64_t hashed = 0;
  const auto keys_for = [&](std::uint64_t multiplier) {
    std::vector<HashedNode> nodes = hashed_nodes(bvh, which, multiplier);
    hashed = nodes.size();
    return nodes;
  };
  Result<PerfectHash> hash = is_leaf(bvh.root) ? PerfectHash{} : make_perfect_hash(keys_for, bvh.has_narrow_keys());
  if (!hash) return hash.error();
  bvh.displacements = hash->displacements, bvh.slots = hash->slots;
  bvh.hash_multiplier = hash->multiplier, bvh.hashed = which;
  note_keys(bvh, hashed, report);
  if (hashed > 0) note_tables(bvh, *hash, hashed, report);
  return Done{};
}

}  // namespace accel
