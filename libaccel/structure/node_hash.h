// From the key of a node to its reference, without a search: keys of nodes by their path, and a perfect hash of keys.
//
// Binder and Keller 2016, "Efficient Stackless Hierarchy Traversal on GPUs with Backtracking in Constant Time" [BK16], sections
// 2.2 and 2.2.1. The root has key 1, the children of key k have keys 2 k and 2 k + 1: the sibling of k is k ^ 1, an ancestor is
// k shifted right. A table of displacements turns k into the index of a slot, and the slot holds the reference:
//
//   d = displacements[bucket(k)];  reference = slots[(k + d) mod H]
//
// A bucket with a single key holds the reference itself in place of d.
//
// Widths. Keys have 32 bits in trees down to depth 31, where all arithmetic is modulo 2^32, and 64 bits beyond, modulo 2^64;
// k + d wraps the same way wherever it is computed, because it is computed here only. In trees deeper than 63 a key is a
// window: when it fills its 64 bits, its upper half is folded into a prefix, which is added to the lower half in hashing
// (NodeKey). Prefixes are random numbers, so different nodes have different sums almost surely; the builder makes sure.
//
// Deviations. [BK16] reads d at k mod D. Here the bucket is taken from the top bits of k times an odd number (Fibonacci
// hashing): the last bits of keys are the last turns of paths, which in skewed trees are the same for most of the nodes, so
// that one bucket would hold them all and no displacement fit. mod H is two multiplications by a precomputed reciprocal
// (Barrett). [BK16] halves the range of references to have a bit that tells them from displacements; here references beyond
// that range are never put into the displacement table, so there is no limit.
#pragma once

#include <cstdint>
#include <type_traits>

#include "libaccel/core/hd.h"

namespace accel {

// What a child slot or a root refers to: an inner node by index, or, with the top bit set, a leaf by its first quad.
using NodeRef = std::uint32_t;
inline constexpr NodeRef kLeafBit = 0x80000000u;
inline constexpr NodeRef kNoNode = 0xffffffffu;

ACCEL_HD bool is_leaf(NodeRef ref) { return (ref & kLeafBit) != 0; }
ACCEL_HD std::uint32_t leaf_quad(NodeRef ref) { return ref & ~kLeafBit; }
ACCEL_HD NodeRef leaf_ref(std::uint32_t quad) { return quad | kLeafBit; }

// The deepest trees whose keys fit; the depth of the root is 0, and a leaf below n inner nodes has depth n.
inline constexpr std::uint32_t kMaxDepth32 = 31;
inline constexpr std::uint32_t kMaxDepth64 = 63;

// A key in a tree of any depth. The window has the last turns below a leading one: all of them down to depth 63, and beyond
// between kLeastTurns and 63.
inline constexpr int kLeastTurns = 33;
struct NodeKey {
  std::uint64_t window = 1;
  std::uint64_t prefix = 0;  // of what the window has lost

  // What is hashed.
  ACCEL_HD std::uint64_t hashed() const { return window + prefix; }
  ACCEL_HD bool is_full() const { return window >> kMaxDepth64 != 0; }
  // The part of a full window that goes, leading one included.
  ACCEL_HD std::uint32_t upper_half() const { return static_cast<std::uint32_t>(window >> 32); }
  // Gives up the upper half, so that there is room for a turn. `multiplier` is the hash's.
  ACCEL_HD void fold(std::uint64_t multiplier) {
    std::uint64_t mixed = (prefix + upper_half()) * multiplier;  // then the last steps of SplitMix64
    mixed = (mixed ^ mixed >> 30) * 0xbf58476d1ce4e5b9u;
    mixed = (mixed ^ mixed >> 27) * 0x94d049bb133111ebu;
    prefix = mixed ^ mixed >> 31;
    window = std::uint64_t{1} << 32 | (window & 0xffffffffu);
  }
  ACCEL_HD NodeKey child(std::uint32_t side, std::uint64_t multiplier) const {
    NodeKey result = *this;
    if (is_full()) result.fold(multiplier);
    result.window = result.window << 1 | side;
    return result;
  }
};

// An entry of the displacement table: a displacement below 2^31, or, with the top bit set, a reference: the next bit is its
// leaf bit, and 30 bits are left.
inline constexpr std::uint32_t kDirectBit = 0x80000000u;
inline constexpr std::uint32_t kDirectLeafBit = 0x40000000u;
ACCEL_HD bool is_direct(std::uint32_t entry) { return (entry & kDirectBit) != 0; }
ACCEL_HD NodeRef direct_ref(std::uint32_t entry) { return (entry << 1 & kLeafBit) | (entry & (kDirectLeafBit - 1)); }
ACCEL_HD bool fits_direct(NodeRef ref) { return leaf_quad(ref) < kDirectLeafBit; }
ACCEL_HD std::uint32_t direct_entry(NodeRef ref) { return kDirectBit | (is_leaf(ref) ? kDirectLeafBit : 0u) | leaf_quad(ref); }

// The high half of a product.
ACCEL_HD std::uint32_t multiply_high(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(a) * b >> 32);
}
ACCEL_HD std::uint64_t multiply_high(std::uint64_t a, std::uint64_t b) {
  __extension__ using Wide = unsigned __int128;
  return static_cast<std::uint64_t>(static_cast<Wide>(a) * b >> 64);
}

// The tables, as kernels read them. Key is std::uint32_t or std::uint64_t, by the depth of the tree.
struct NodeHashView {
  const std::uint32_t* displacements = nullptr;  // null: no key of this tree is ever looked up
  const NodeRef* slots = nullptr;
  std::uint64_t multiplier = 0;       // odd; its upper half serves 32-bit keys
  std::uint64_t reciprocal = 0;       // floor((2^bits - 1) / H)
  std::uint32_t slot_count = 0;       // H
  std::uint32_t log2_of_buckets = 0;  // of D; at least 1

  template <class Key>
  ACCEL_HD Key factor() const {
    if constexpr (sizeof(Key) == 4)
      return static_cast<std::uint32_t>(multiplier >> 32) | 1u;
    else
      return multiplier;
  }

  template <class Key>
  ACCEL_HD std::uint32_t bucket(Key key) const {
    return static_cast<std::uint32_t>(static_cast<Key>(key * factor<Key>()) >> (8 * sizeof(Key) - log2_of_buckets));
  }

  // key mod H: Barrett's quotient is right or one too small.
  template <class Key>
  ACCEL_HD std::uint32_t residue(Key key) const {
    const Key quotient = multiply_high(key, static_cast<Key>(reciprocal));
    const auto rest = key - quotient * slot_count;
    return static_cast<std::uint32_t>(rest >= slot_count ? rest - slot_count : rest);
  }

  template <class Key>
  ACCEL_HD std::uint32_t slot(Key key, std::uint32_t displacement) const {
    return residue(static_cast<Key>(key + displacement));
  }

  // The reference of a key that is stored.
  template <class Key>
  NodeRef find(Key key) const {
    const std::uint32_t entry = displacements[bucket(key)];
    return is_direct(entry) ? direct_ref(entry) : slots[slot(key, entry)];
  }
};

// The reciprocal for tables of H slots.
template <class Key>
constexpr std::uint64_t reciprocal_of(std::uint32_t slot_count) {
  return static_cast<Key>(~Key{0}) / slot_count;
}

}  // namespace accel
