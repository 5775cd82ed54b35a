// The cheapest forests of wide trees over a node of a binary tree: what collapses choose by.
//
// Wald, Benthin and Boulos 2008; Ylitie, Karras and Laine 2017: see build/collapse_wide.h, which has the references and says
// what a cost is. A forest of at most so many roots: it may have fewer where more cost as much.
#pragma once

#include <algorithm>
#include <cstdint>

#include "libaccel/build/wide_forests_simd.h"
#include "libaccel/structure/bvh8.h"

namespace accel {

inline constexpr int kMostForestRoots = static_cast<int>(kBvh8Arity) - 1;  // of a forest that is not a whole node

// The least costs of forests over one binary node, and the choices that make them.
class WideForests {
 public:
  // Undefined, until choose().
  WideForests() = default;
  // Over a leaf, which is the only root there can be.
  explicit WideForests(float leaf_cost) { std::fill(cost_, cost_ + kBvh8Arity, with_choice(leaf_cost, 0)); }

  float cost(int roots) const { return cost_[roots - 1]; }
  bool is_leaf() const { return choice_of(cost_[0]) != 0; }
  // How many of the roots are in the left subtree; `roots` becomes one if the node itself is cheaper. For roots > 1.
  int left(int& roots) const {
    const auto left = static_cast<int>(choice_of(cost_[roots - 1]));
    if (left == 0) roots = 1;
    return left;
  }

  // From those of the children. `node_cost` and `leaf_cost` are the node's own.
  void choose(const WideForests& left, const WideForests& right, float node_cost, float leaf_cost) {
    choose_split(left.cost_, right.cost_, cost_);
    const float inner = cost_[kMostForestRoots] + node_cost;
    const float one = with_choice(std::min(leaf_cost, inner), 0);
    for (int roots = 2; roots <= kMostForestRoots; ++roots) cost_[roots - 1] = min_of(one, cost_[roots - 1]);
    cost_[0] = with_choice(one, leaf_cost <= inner ? 1 : 0);
  }

 private:
  // [roots - 1], with how many of them are on the left, or 0 for the node itself; of one root, whether it is a leaf. The last
  // is that of a whole node's children.
  alignas(16) float cost_[kBvh8Arity];
};
static_assert(sizeof(WideForests) == 32);

}  // namespace accel
