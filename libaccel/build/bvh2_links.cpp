#include "libaccel/build/bvh2_links.h"

#include <algorithm>

#include "libaccel/build/bvh2_walk_parallel.h"
#include "libaccel/build/parallel.h"

namespace accel {
namespace {

template <class T>
Buffer<T> parallel_copy(const Buffer<T>& from) {
  Buffer<T> to(from.size());
  for_chunks(0, from.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    std::copy(from.data() + begin, from.data() + end, to.data() + begin);
  });
  return to;
}

void write_leaf_links(LeafQuad* leaves, NodeRef leaf, const PlaceLinks& links, Bvh2Links kind) {
  std::copy_n(links.link, 3, leaves[terminator_of(leaves, leaf)].link);
  const std::uint32_t first = leaf_quad(leaf);
  for (const std::uint32_t i : {0u, 1u}) leaves[first + 1 + i].word = kind == Bvh2Links::uncles ? links.link[i] : 0u;
}

}  // namespace

void add_links(Bvh2& bvh, Bvh2Links kind) {
  if (bvh.root == kNoNode) return;
  Buffer<Bvh2Node> nodes = parallel_copy(bvh.nodes);
  Buffer<LeafQuad> leaves = parallel_copy(bvh.leaves);
  walk_bvh2_parallel(bvh.view(), {.ref = bvh.root}, bvh.hash_multiplier, [&](const Bvh2Place& place) {
    const PlaceLinks links = links_of(place, kind);
    if (is_leaf(place.ref))
      write_leaf_links(leaves.data(), place.ref, links, kind);
    else
      std::copy_n(links.link, 2, nodes[place.ref].link);
  });
  bvh.nodes = nodes, bvh.leaves = leaves, bvh.links = kind;
}

}  // namespace accel
