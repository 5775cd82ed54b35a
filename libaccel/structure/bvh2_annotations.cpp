#include "libaccel/structure/bvh2_annotations.h"

#include <algorithm>
#include <bit>
#include <string>
#include <vector>

#include "libaccel/structure/bvh2_walk.h"

namespace accel {
namespace {

std::string name_of(NodeRef ref) {
  return is_leaf(ref) ? "the leaf at quad " + std::to_string(leaf_quad(ref)) : "node " + std::to_string(ref);
}

// Whether all words of links are those that the place implies, also where there are none.
bool has_right_links(const Bvh2View& view, const Bvh2Place& place, Bvh2Links kind) {
  const auto [link] = links_of(place, kind);
  if (!is_leaf(place.ref)) return std::equal(link, link + 2, view.nodes[place.ref].link);
  const std::uint32_t first = leaf_quad(place.ref), end = terminator_of(view.leaves, place.ref);
  if (!std::equal(link, link + 3, view.leaves[end].link)) return false;
  const bool in_first = kind == Bvh2Links::uncles;
  for (std::uint32_t quad = first; quad < end; quad += kQuadsPerTriangle)
    for (const std::uint32_t i : {0u, 1u})
      if (view.leaves[quad + 1 + i].word != (in_first && quad == first ? link[i] : 0u)) return false;
  return true;
}

Status check_links(const Bvh2& bvh) {
  if (bvh.links > Bvh2Links::uncles) return Error{"the kind of links is none that there is"};
  const Bvh2View view = bvh.view();
  NodeRef wrong = kNoNode;
  const bool good = walk_bvh2(view, {bvh.root}, bvh.hash_multiplier, [&](const Bvh2Place& place) {
    wrong = place.ref;
    return has_right_links(view, place, bvh.links);
  });
  return good ? Status(Done{}) : Status(Error{name_of(wrong) + " has links that are not its own"});
}

// What the tables hold, apart from which keys they answer.
std::uint64_t stored_entries(const Bvh2& bvh) {
  const auto direct = std::count_if(bvh.displacements.begin(), bvh.displacements.end(), is_direct);
  const auto in_slots = std::count_if(bvh.slots.begin(), bvh.slots.end(), [](NodeRef ref) { return ref != kNoNode; });
  return static_cast<std::uint64_t>(direct + in_slots);
}

Status check_hash_sizes(const Bvh2& bvh) {
  const std::size_t buckets = bvh.displacements.size(), slots = bvh.slots.size();
  if (bvh.hashed > HashedKeys::all) return Error{"the kind of hashed keys is none that there is"};
  if (bvh.hashed == HashedKeys::none && buckets + slots + bvh.hash_multiplier != 0)
    return Error{"there is a hash table, but no keys are stated to be hashed"};
  if ((buckets == 0) != (slots == 0)) return Error{"a hash has one table without the other"};
  if (buckets == 0) return Done{};
  if (!std::has_single_bit(buckets) || buckets < 2 || buckets >= kDirectBit || slots >= kDirectBit)
    return Error{"a hash has " + std::to_string(buckets) + " displacements, which are no power of two, or too many slots"};
  return Done{};
}

// After the sizes: every key that must be there is answered by its node, and nothing else is there.
Status check_hash(const Bvh2& bvh) {
  if (bvh.hashed == HashedKeys::none) return Done{};
  const Bvh2View view = bvh.view();
  const bool all = bvh.hashed == HashedKeys::all, narrow = bvh.has_narrow_keys();
  std::uint64_t needed = 0;
  NodeRef wrong = kNoNode;
  const bool good = walk_bvh2(view, {bvh.root}, bvh.hash_multiplier, [&](const Bvh2Place& place) {
    const bool is_hashed =
        place.sibling != kNoNode && (all || has_inner_node_below(view.nodes, place.sibling, kHashedDistance));
    if (!is_hashed) return true;
    ++needed, wrong = place.ref;
    if (view.hash.displacements == nullptr) return false;
    const std::uint64_t key = place.key.hashed();
    return (narrow ? view.hash.find(static_cast<std::uint32_t>(key)) : view.hash.find(key)) == place.ref;
  });
  if (!good) return Error{"the hash does not find " + name_of(wrong)};
  if (stored_entries(bvh) != needed)
    return Error{"the hash holds " + std::to_string(stored_entries(bvh)) + " nodes, but " + std::to_string(needed) +
                 " are to be found"};
  return Done{};
}

// Any order of children will do; the targets follow from it.
bool has_right_skips(const Bvh2& bvh, const std::uint32_t* skips) {
  struct Pending {
    NodeRef node;
    std::uint32_t target;
  };
  std::vector<Pending> pending;
  if (!is_leaf(bvh.root)) pending.push_back({bvh.root, kNoSkip});
  while (!pending.empty()) {
    const auto [node, target] = pending.back();
    pending.pop_back();
    if (skip_target(skips[node]) != target) return false;
    const std::uint32_t first = first_child(skips[node]);
    const NodeRef* const child = bvh.nodes[node].child;
    if (!is_leaf(child[first])) pending.push_back({child[first], node});
    if (!is_leaf(child[first ^ 1u])) pending.push_back({child[first ^ 1u], target});
  }
  return true;
}

Status check_skips(const Bvh2& bvh, const Buffer<std::uint32_t>& skips, std::size_t orders) {
  if (skips.empty()) return Done{};
  if (skips.size() != orders * bvh.nodes.size()) return Error{"skip pointers are not one for each node"};
  for (std::size_t order = 0; order < orders; ++order)
    if (!has_right_skips(bvh, skips.data() + order * bvh.nodes.size())) return Error{"a skip pointer leads astray"};
  return Done{};
}

bool same_box(const Aabb& a, const Aabb& b) { return a.contains(b) && b.contains(a); }

// An Octo-BVH of unknown origin against its tree: every node and leaf comes once, leaves with their boxes.
class OctoCheck {
 public:
  explicit OctoCheck(const Bvh2& bvh) : bvh_(bvh), leaf_(bvh.leaves.size(), kNone), seen_(bvh.octo.size()) {
    for (std::uint32_t i = 0; i < bvh.nodes.size(); ++i)
      for (const std::uint32_t c : {0u, 1u})
        if (is_leaf(bvh.nodes[i].child[c])) leaf_[leaf_quad(bvh.nodes[i].child[c])] = 2 * i + c, ++leaves_;
  }

  // Children come after their parents, so there are no cycles.
  bool run() {
    seen_[0] = true;
    for (std::uint32_t i = 0; i < bvh_.octo.size(); ++i) {
      if (!seen_[i]) return false;  // nobody's child
      for (std::uint32_t c = 0; c < kOctoArity; ++c)
        if (!check_child(i, c)) return false;
    }
    return leaves_ == 0;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  bool check_child(std::uint32_t i, std::uint32_t c) {
    const OctoNode& node = bvh_.octo[i];
    const NodeRef child = node.child[c];
    const Aabb box = node.bounds(c);
    const bool is_none = child == kNoNode;
    if ((node.child_mask >> c & 1u) != (is_none ? 0u : 1u) || (node.leaf_mask >> c & 1u) != (is_leaf(child) ? 1u : 0u))
      return false;
    if (is_none) return true;
    if (box.empty()) return false;
    if (is_leaf(child)) return check_leaf(leaf_quad(child), box);
    if (child <= i || child >= bvh_.octo.size() || seen_[child]) return false;
    return seen_[child] = true;
  }

  bool check_leaf(std::uint32_t quad, const Aabb& box) {
    if (quad >= leaf_.size() || leaf_[quad] == kNone) return false;
    const std::uint32_t at = leaf_[quad];
    leaf_[quad] = kNone, --leaves_;
    return same_box(bvh_.nodes[at / 2].bounds(static_cast<int>(at % 2)), box);
  }

  const Bvh2& bvh_;
  std::vector<std::uint32_t> leaf_;  // by quad: whose child it is, until it has been met
  std::vector<bool> seen_;           // of the nodes
  std::uint64_t leaves_ = 0;
};

Status check_octo(const Bvh2& bvh) {
  if (bvh.octo.empty()) return Done{};
  if (bvh.nodes.empty() || bvh.nodes.size() >= kMaxOctoNodes || bvh.octo.size() > bvh.nodes.size())
    return Error{"there are octo nodes where none can be"};
  return OctoCheck(bvh).run() ? Status(Done{}) : Status(Error{"the octo nodes are not those of the tree"});
}

}  // namespace

Status check_annotations(const Bvh2& bvh) {
  if (Status status = check_hash_sizes(bvh); !status) return status;  // before there can be a view
  if (Status status = check_links(bvh); !status) return status;
  if (Status status = check_hash(bvh); !status) return status;
  if (Status status = check_skips(bvh, bvh.skips, 1); !status) return status;
  if (Status status = check_skips(bvh, bvh.octant_skips, kOctants); !status) return status;
  return check_octo(bvh);
}

}  // namespace accel
