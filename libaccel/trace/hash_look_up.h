// From the key of a node to its reference, as traversers look it up: structure/node_hash.h, with every load observed.
#pragma once

#include <cstdint>

#include "libaccel/structure/bvh2.h"
#include "libaccel/trace/traverser.h"

namespace accel {

namespace detail {

template <class Key, class Observer>
ACCEL_HD NodeRef find_observed(const NodeHashView& hash, Key key, Observer& observer) {
  const std::uint32_t* const displacement = hash.displacements + hash.bucket(key);
  observer.load(Memory::hash, displacement, sizeof *displacement);
  if (is_direct(*displacement)) return direct_ref(*displacement);
  const NodeRef* const slot = hash.slots + hash.slot(key, *displacement);
  observer.load(Memory::hash, slot, sizeof *slot);
  return *slot;
}

}  // namespace detail

// The node with a key that is in the tree's hash. Keys of 64 bits serve shallow trees too, whose hash is one of 32 bits.
template <class Key, class Observer>
ACCEL_HD NodeRef look_up(const Bvh2View& view, Key key, Observer& observer) {
  if constexpr (sizeof key == 8)
    if (view.depth > kMaxDepth32) return detail::find_observed(view.hash, key, observer);
  return detail::find_observed(view.hash, static_cast<std::uint32_t>(key), observer);
}

}  // namespace accel
