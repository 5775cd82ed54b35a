#include "libaccel/build/reinsertion_search.h"

#include <utility>

namespace accel {
namespace {

// Half the areas of the children's boxes: with another box, and as they are.
struct ChildAreas {
  float merged[2], own[2];
};

// Lane by lane, in loops that compilers make vectors of.
ChildAreas areas_of_children(const Bvh2Node& node, const Aabb& box) {
  float extent[3][4], area[4];
  for (int a = 0; a < 3; ++a) {
    const float* const plane = node.planes[a];
    const float lo[4] = {min_of(plane[0], box.lo[a]), min_of(plane[1], box.lo[a]), plane[0], plane[1]};
    const float hi[4] = {max_of(plane[2], box.hi[a]), max_of(plane[3], box.hi[a]), plane[2], plane[3]};
    for (int lane = 0; lane < 4; ++lane) extent[a][lane] = hi[lane] - lo[lane];
  }
  for (int lane = 0; lane < 4; ++lane)
    area[lane] = extent[0][lane] * (extent[1][lane] + extent[2][lane]) + extent[1][lane] * extent[2][lane];
  return {{area[0], area[1]}, {area[2], area[3]}};
}

}  // namespace

Reinsertion ReinsertionSearch::best_place(NodeRef subtree) {
  using Tree = ReinsertionTree;
  Tree::Slot slot = tree_.slot_of(subtree);
  box_ = tree_.box_at(slot), area_ = box_.half_area();
  best_ = {0, subtree, kNoNode};

  // Without the subtree there is no need for its parent; and boxes above it shrink to what is left in them.
  Aabb rest = tree_.box_at(slot ^ 1u);
  const NodeRef sibling = tree_.ref_at(slot ^ 1u);
  slot = tree_.slot_of(slot / 2);
  float saved = tree_.box_at(slot).half_area();
  if (!is_leaf(sibling)) search_below(sibling, saved - merged_area(rest) + rest.half_area());

  while (slot != Tree::kRootSlot) {
    // In the aunt, the subtree is still within the ancestor whose children these are: that one, and all above, stay as they
    // are. So `saved` counts what has shrunk below.
    const NodeRef aunt = tree_.ref_at(slot ^ 1u);
    const Aabb aunt_box = tree_.box_at(slot ^ 1u);
    const float gain = saved - merged_area(aunt_box);
    take(gain, aunt);
    if (!is_leaf(aunt)) search_below(aunt, gain + aunt_box.half_area());

    // As the ancestor's sibling it gets a parent as large as the ancestor was.
    rest.extend(aunt_box);
    const NodeRef ancestor = slot / 2;
    slot = tree_.slot_of(ancestor);
    const float ancestor_area = tree_.box_at(slot).half_area();
    saved += ancestor_area - rest.half_area();
    take(saved - ancestor_area, ancestor);
  }
  return best_;
}

// `saved` is what is left for places below an inner node, which has grown for the subtree. The more promising child comes
// first.
void ReinsertionSearch::search_below(NodeRef inner, float saved) {
  std::size_t size = 0;
  pending_[size++] = {inner, saved};
  while (size > 0) {
    const Pending next = pending_[--size];
    if (!may_gain(next.saved)) continue;
    const Bvh2Node& node = tree_.node(next.inner);
    const ChildAreas areas = areas_of_children(node, box_);
    Pending child[2];
    for (int c = 0; c < 2; ++c) {
      const float gain = next.saved - areas.merged[c];
      take(gain, node.child[c]);
      child[c] = {node.child[c], gain + areas.own[c]};
    }
    if (child[0].saved > child[1].saved) std::swap(child[0], child[1]);
    for (const Pending& one : child)
      if (!is_leaf(one.inner) && may_gain(one.saved)) pending_[size++] = one;
  }
}

}  // namespace accel
