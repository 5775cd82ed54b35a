// Builds two levels of two-box BVHs (structure/two_level.h) over a scene made of instances.
//
// One tree a mesh by Sbvh, whether the mesh is placed once or a thousand times; one over the instances' world boxes by the
// object splits of BinnedSah, with one instance a leaf unless max_depth forbids it, since entering an instance costs more than
// any number of box tests would suggest. Meshes are built one after the other, each on all threads. Instances without a
// triangle that a ray can hit are in no leaf.
//
// World boxes. An instance's box is that of the boxes that its mesh's tree has a few levels down (kFrontier of them), each
// taken through the map: tighter than the box of a turned box, and as cheap. With exact numbers it contains every point of the
// instance. It is computed in double and rounded outwards, so that
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

#include "libaccel/build/builder.h"
#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/structure/two_level.h"

namespace accel {

struct InstanceBuilder {
  static constexpr const char* kName = "instances";
  using Structure = TwoLevelBvh;
  static Result<Built<TwoLevelBvh>> build(const InstancedMeshes& scene, const BuildOptions& options);
};

}  // namespace accel
