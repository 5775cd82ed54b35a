// Builds the tree over the instances of a scene: two-box, by the object splits of BinnedSah over the instances' world boxes,
// with one instance a leaf unless max_depth forbids it, since entering an instance costs more than any number of box tests
// would suggest. Leaves name instances by number, in place of prim_ids. Instances without a triangle that a ray can hit are in
// no leaf.
//
// World boxes. An instance's box is that of the boxes that its mesh's tree has some levels down, each taken through the map:
// the more, the tighter. With exact numbers it contains every point of the instance. It is computed in double and rounded
// outwards, so that
//
//   1. No true hit is lost, wherever a ray comes from. If the exact ray meets the exact instance at t*, it meets a box that
//      contains it at a distance not above t*, and the slab test (trace/box_pair.h) errs on the safe side. What the search in
//      the instance's space makes of the rounded ray is that search's business, and watertight there.
//
// The rounded ray, though, may meet what the exact one passes by a hair, or earlier than that: a hit outside of the box. So
// that these, too, are found as by a search through all instances, and ties between instances are ties, boxes are padded:
//
//   2. Let L be the inverse map, T its translation, and W_j a bound of |p_j - T_j| for origins and hits p. In the instance's
//      space the origin is off by gamma(5) sum_j |L_ij| W_j, and t times the direction by gamma(4) sum_j |L_ij| 2 W_j
//      (core/affine.h; |t d_j| is the difference of a hit and an origin). The triangle test moves vertices by gamma(5) of their
//      distance from the origin, at most sum_j |L_ij| 2 W_j, and rounding t adds one u of that distance. Back in the world a
//      hit is off by no more than
//
//        pad_a = gamma(26) sum_i |M_ai| sum_j |L_ij| W_j        (5 + 2 * 4 + 2 * 5 + 2 = 25, and one for these sums)
//
//      along axis a. Origins up to kPaddingReach times the scene's largest extent away from its box are covered, as in
//      structure/padding.h; from farther away only 1. holds, and answers may differ by what rounding excuses.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "libaccel/build/builder.h"
#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/structure/bvh2.h"

namespace accel {

// The inverse of each instance's map. May throw std::bad_alloc.
std::vector<AffineInverse> inverses(std::span<const Instance> instances);

// How many boxes an instance's box is made of, where all instances together may have so many for each triangle of the meshes:
// 32 to 512. In forests, 512 in place of 32 save rays up to 6 %; where instances are many and small, they would take longer
// than all else.
std::size_t boxes_an_instance(const InstancedMeshes& scene, double per_triangle);

// What a report says of them.
BuildNote instances_note(const InstancedMeshes& scene, std::uint64_t stored_triangles);

// The boxes of a mesh's tree that a search in breadth has come to before there may be more than `most`: together they contain
// what a ray can hit of the mesh. Finite, also where those of a file are not.
template <class Node>
std::vector<Aabb> boxes_below(const Node* nodes, NodeRef root, const Aabb& bounds, std::size_t most) {
  constexpr std::size_t kArity = std::extent_v<decltype(Node::child)>;
  struct Entry {
    NodeRef node;
    Aabb box;
  };
  std::vector<Entry> entries;
  if (root != kNoNode) entries.push_back({root, bounds});
  for (bool grows = true; grows && kArity * entries.size() <= most;) {
    std::vector<Entry> next;
    for (const Entry& entry : entries) {
      if (is_leaf(entry.node)) {
        next.push_back(entry);
        continue;
      }
      const Node& node = nodes[entry.node];
      for (std::uint32_t c = 0; c < kArity && node.child[c] != kNoNode; ++c)
        next.push_back({node.child[c], node.bounds(static_cast<int>(c))});
    }
    grows = next.size() > entries.size();
    entries = std::move(next);
  }
  constexpr Vec3 kFarthest{kMaxCoordinate, kMaxCoordinate, kMaxCoordinate};
  std::vector<Aabb> boxes;
  for (const Entry& entry : entries) boxes.push_back(intersection(entry.box, {-kFarthest, kFarthest}));
  return boxes;
}

// to_object are inverses(scene.instances()). mesh_boxes[m] are boxes_below() of mesh m. May throw std::bad_alloc.
Result<Built<Bvh2>> build_top_level(const InstancedMeshes& scene, std::span<const AffineInverse> to_object,
                                    std::span<const std::vector<Aabb>> mesh_boxes, const BuildOptions& options);

}  // namespace accel
