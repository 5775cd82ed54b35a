// The cheapest forests of wide trees over a node of a binary tree: what collapses choose by.
//
// Wald, Benthin and Boulos 2008; Ylitie, Karras and Laine 2017: see build/collapse_wide.h, which has the references and says
// what a cost is.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "libaccel/structure/bvh8.h"

namespace accel {

inline constexpr int kMostForestRoots = static_cast<int>(kBvh8Arity) - 1;  // of a forest that is not a whole node

// The least costs of forests over one binary node, and the choices that make them.
class WideForests {
 public:
  float cost(int roots) const { return cost_[roots - 1]; }
  bool is_leaf() const { return left_[0] != 0; }
  // How many of the roots are in the left subtree; `roots` becomes the number that is worth having. For roots > 1.
  int left(int& roots) const {
    while (roots > 1 && left_[roots - 1] == 0) --roots;
    return left_[roots - 1];
  }

  // From those of the children. `node_cost` and `leaf_cost` are the node's own.
  template <class CostOf>
  void choose(const CostOf& cost_of, float node_cost, float leaf_cost) {
    // All numbers of roots at once, for each number of them on the left; what is impossible costs infinitely much.
    constexpr int kLanes = static_cast<int>(kBvh8Arity);
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    float right[2 * kLanes], least[kLanes];
    std::int32_t left[kLanes];
    std::fill(right, right + 2 * kLanes, kInfinity), std::fill(least, least + kLanes, kInfinity);
    std::fill(left, left + kLanes, 1);
    for (int k = 1; k <= kMostForestRoots; ++k) right[kLanes + k - 1] = cost_of(1, k);
    for (int k = 1; k <= kMostForestRoots; ++k) {
      const float cost = cost_of(0, k);
      for (int lane = 0; lane < kLanes; ++lane) {
        const float sum = cost + right[kLanes + lane - k];
        left[lane] = sum < least[lane] ? k : left[lane];
        least[lane] = sum < least[lane] ? sum : least[lane];
      }
    }
    for (int roots = 2; roots <= kMostForestRoots + 1; ++roots) set(roots, least[roots - 1], left[roots - 1]);
    const float inner = node_of_eight_ + node_cost;
    left_[0] = leaf_cost <= inner ? 1 : 0;
    cost_[0] = std::min(leaf_cost, inner);
    for (int roots = 2; roots <= kMostForestRoots; ++roots)
      if (!(cost_[roots - 1] < cost_[roots - 2])) cost_[roots - 1] = cost_[roots - 2], left_[roots - 1] = 0;
  }

 private:
  void set(int roots, float cost, int left) {
    left_[roots - 1] = static_cast<std::uint8_t>(left);
    if (roots <= kMostForestRoots)
      cost_[roots - 1] = cost;
    else
      node_of_eight_ = cost;
  }

  float cost_[kMostForestRoots];
  float node_of_eight_;
  std::uint8_t left_[kMostForestRoots + 1];  // [roots - 1]; 0: fewer roots are as good; of one root: whether it is a leaf
};

}  // namespace accel
