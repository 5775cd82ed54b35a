#include "libaccel/build/bvh2_octo.h"

#include <algorithm>
#include <vector>

#include "libaccel/build/parallel.h"

namespace accel {
namespace {

struct Child {
  NodeRef ref;
  Aabb box;
};

// What becomes one node: descendants of a Bvh2's node that cover it.
struct Family {
  Child child[kOctoArity];
  std::uint32_t count = 0;

  void add(const Bvh2Node& node, int c) { child[count++] = {node.child[c], node.bounds(c)}; }
};

Family collapse(const Bvh2Node* nodes, NodeRef root) {
  Family family;
  family.add(nodes[root], 0), family.add(nodes[root], 1);
  while (family.count < kOctoArity) {
    Child* largest = nullptr;
    for (std::uint32_t c = 0; c < family.count; ++c) {
      Child& child = family.child[c];
      if (!is_leaf(child.ref) && (largest == nullptr || half_area_in_double(child.box) > half_area_in_double(largest->box)))
        largest = &child;
    }
    if (largest == nullptr) break;
    const Bvh2Node& opened = nodes[largest->ref];
    *largest = {opened.child[0], opened.bounds(0)};
    family.add(opened, 1);
  }
  return family;
}

// How well a child fits a place: how far its centre lies towards that corner of the family's box. Doubled.
float fit(const Child& child, const Vec3& middle, std::uint32_t place) {
  float sum = 0;
  for (int a = 0; a < 3; ++a) {
    const float ahead = (child.box.lo[a] + child.box.hi[a]) - middle[a];
    sum += (place >> a & 1u) != 0 ? ahead : -ahead;
  }
  return sum;
}

// Puts the children into places, the pair that fits best first.
OctoNode place_children(const Family& family) {
  Aabb box;
  for (std::uint32_t c = 0; c < family.count; ++c) box.extend(family.child[c].box);
  const Vec3 middle = box.lo + box.hi;
  OctoNode node;
  node.clear();
  bool is_placed[kOctoArity] = {};
  for (std::uint32_t placed = 0; placed < family.count; ++placed) {
    std::uint32_t best_child = kOctoArity, best_place = 0;
    float best = 0;
    for (std::uint32_t c = 0; c < family.count; ++c)
      for (std::uint32_t place = 0; place < kOctoArity && !is_placed[c]; ++place) {
        if (node.child[place] != kNoNode) continue;
        const float value = fit(family.child[c], middle, place);
        if (best_child == kOctoArity || value > best) best_child = c, best_place = place, best = value;
      }
    is_placed[best_child] = true;
    node.set_child(best_place, family.child[best_child].ref, family.child[best_child].box);
  }
  return node;
}

}  // namespace

Status add_octo(Bvh2& bvh) {
  if (bvh.nodes.empty()) return Done{};
  if (bvh.nodes.size() >= kMaxOctoNodes)
    return Error{"the tree has " + std::to_string(bvh.nodes.size()) + " nodes, and an Octo-BVH has fewer than " +
                 std::to_string(kMaxOctoNodes)};
  const Bvh2Node* const nodes = bvh.nodes.data();
  std::vector<OctoNode> octo;
  std::vector<NodeRef> level{bvh.root};  // of the Bvh2
  while (!level.empty()) {
    const std::size_t first = octo.size();
    octo.resize(first + level.size());
    for_chunks(0, level.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) octo[first + i] = place_children(collapse(nodes, level[i]));
    });
    std::vector<NodeRef> below;
    const auto next = static_cast<NodeRef>(octo.size());
    for (std::size_t i = first; i < octo.size(); ++i)
      for (NodeRef& child : octo[i].child) {
        if (is_leaf(child)) continue;  // or kNoNode
        below.push_back(child);
        child = next + static_cast<NodeRef>(below.size() - 1);
      }
    level = std::move(below);
  }
  bvh.octo = Buffer<OctoNode>::copy_of(octo);
  return Done{};
}

}  // namespace accel
