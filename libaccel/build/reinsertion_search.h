// Where in a tree a subtree would be placed best: the search of reinsertion (build/reinsertion.h).
//
// Meister and Bittner 2018, section 3.2: from the subtree's parent upwards, and from each node on the way down into its other
// child, as far as a better place may be there: whatever becomes the subtree's new parent is at least as large as it is. Most
// searches end near where they began; the way up is most of the work. Deviation: what is below a child is searched depth first
// with a small stack of what may still be better, in place of the paper's walk without one.
//
// Areas are in single precision here, so a gain that is found is an estimate. Gains of large scenes may overflow to infinity,
// which is still a gain; NaN is none.
#pragma once

#include <array>

#include "libaccel/build/builder.h"
#include "libaccel/build/reinsertion_tree.h"

namespace accel {

// That a subtree becomes the sibling of `target`, which makes the sum of the inner nodes' areas smaller by `gain`.
struct Reinsertion {
  float gain = 0;
  NodeRef subtree = kNoNode, target = kNoNode;
};

// Searches for one subtree after the other. Threads need a search each; the tree must not change.
class ReinsertionSearch {
 public:
  explicit ReinsertionSearch(const ReinsertionTree& tree) : tree_(tree) {}

  // The best place for a subtree that is not the root. No gain: where it is.
  Reinsertion best_place(NodeRef subtree);

 private:
  // An inner node, and what would be saved if the subtree came to lie in it and cost nothing any more.
  struct Pending {
    NodeRef inner;
    float saved;
  };

  void take(float gain, NodeRef target) {
    if (gain > best_.gain) best_.gain = gain, best_.target = target;
  }
  bool may_gain(float saved) const { return saved - area_ > best_.gain; }
  float merged_area(Aabb box) const { return box.extend(box_), box.half_area(); }
  void search_below(NodeRef inner, float saved);

  const ReinsertionTree& tree_;
  Aabb box_;  // of the subtree
  float area_ = 0;
  Reinsertion best_;
  std::array<Pending, kMaxBuildDepth + 1> pending_;  // siblings of what is on one path, and its last node
};

}  // namespace accel
