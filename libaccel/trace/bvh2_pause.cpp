#include "libaccel/trace/bvh2_pause.h"

#include <limits>
#include <string>

namespace accel {
namespace {

// Numbers at an offset that moves on.
template <class Number>
void put(Number number, std::byte*& at) {
  for (std::size_t i = 0; i < sizeof number; ++i) *at++ = static_cast<std::byte>(number >> 8 * i & 0xffu);
}
template <class Number>
Number get(const std::byte*& at) {
  Number number = 0;
  for (std::size_t i = 0; i < sizeof number; ++i) number |= static_cast<Number>(*at++) << 8 * i;
  return number;
}

// Whether a hit may have this t, or the place is in front of all hits. False for NaN.
bool is_place(HitPlace place) {
  return place.t == kBeforeAllHits.t || (place.t >= 0 && place.t <= std::numeric_limits<float>::max());
}

}  // namespace

std::array<std::byte, kPausedBytes> to_bytes(const PausedTraversal& paused) {
  std::array<std::byte, kPausedBytes> bytes;
  std::byte* at = bytes.data();
  put(paused.key, at), put(paused.trail, at), put(paused.node, at);
  put(std::bit_cast<std::uint32_t>(paused.after.t), at), put(paused.after.prim_id, at);
  return bytes;
}

Result<PausedTraversal> paused_from_bytes(const Bvh2View& view, std::span<const std::byte> bytes) {
  if (bytes.size() != kPausedBytes)
    return Error{"a paused traversal has " + std::to_string(kPausedBytes) + " bytes, and these are " +
                 std::to_string(bytes.size())};
  PausedTraversal paused;
  const std::byte* at = bytes.data();
  paused.key = get<std::uint64_t>(at), paused.trail = get<std::uint64_t>(at), paused.node = get<NodeRef>(at);
  paused.after.t = std::bit_cast<float>(get<std::uint32_t>(at)), paused.after.prim_id = get<std::uint32_t>(at);
  if (paused.is_finished()) return PausedTraversal{};

  if (view.depth > kMaxDepth64) return Error{"a traversal of this tree cannot have been paused: it is too deep"};
  NullObserver observer;
  const NodeRef node = node_at(view, paused.key, observer);
  if (node == kNoNode) return Error{"the key of the paused traversal leads to no node of this tree"};
  if (paused.node != kNoNode && paused.node != node)
    return Error{"the node of the paused traversal is not where its key leads in this tree"};
  if (paused.trail > paused.whole_trail()) return Error{"the trail of the paused traversal is longer than its path"};
  if (!is_place(paused.after)) return Error{"the paused traversal has a t that no hit has"};
  paused.node = node;
  return paused;
}

Status check_pausable(const Bvh2& bvh, std::span<const Bvh2Extras> needs) {
  if (bvh.depth > kMaxDepth64)
    return Error{"the tree is " + std::to_string(bvh.depth) + " levels deep, but the path of a paused traversal has room for " +
                 std::to_string(kMaxDepth64) + "; rebuild it with a smaller max_depth"};
  for (const Bvh2Extras extras : needs) {
    if (bvh.has(extras)) continue;
    const bool is_pruned = extras == Bvh2Extras::full_hash && bvh.hashed == HashedKeys::looked_up;
    return Error{"the tree lacks what resuming needs: " + std::string(Bvh2::extras_name(extras)) +
                 (is_pruned ? "; only those that an unpaused traversal looks up are" : "")};
  }
  return Done{};
}

}  // namespace accel
