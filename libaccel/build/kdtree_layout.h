// Where the pairs of nodes of a kd-tree are stored: pairs that rays tend to visit one after the other share cache lines.
//
// A line of 64 bytes holds four pairs. Lines are filled from the root down: to the pairs that a line holds comes, of those
// below them, the one that a random line is most likely to reach, which is the one whose cell is largest. Pairs that are left
// begin lines of their own, depth first. After van Emde Boas's layouts and Havran's "compact dynamic" one (2000, section 4.3 of
// his thesis "Heuristic Ray Shooting Algorithms"), whose subtrees are balanced.
//
// Deterministic; O(n).
#pragma once

#include <cstdint>
#include <vector>

#include "libaccel/structure/kdtree.h"

namespace accel {

// New numbers of the pairs in `nodes`, whose root is the node `root` with the cell `cell`: parents stay in front of their
// children. Pair 0 of the new order will have the number `first_pair` in the whole tree, which decides where lines begin.
std::vector<std::uint32_t> clustered_pairs(const std::vector<KdNode>& nodes, KdNode root, const Aabb& cell,
                                           std::uint64_t first_pair);

}  // namespace accel
