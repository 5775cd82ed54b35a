// Ordered traversal of a Bvh8 by single rays, eight boxes or four triangles in SIMD lanes: the twin of trace/bvh8_ordered.h,
// the same steps with the same operations, hence the same hits bit for bit. Compiled for every target of the machine's family,
// by Highway; the best that the machine has runs.
//
// Fused operations (FusedSlabs, WoopKahan) are those of the target: targets older than AVX2 have none, and round twice.
//
// The exact distances of a block's candidates are found in lanes, too. Left to the scalar test are triangles that rounding
// makes hard: those that the ray meets in an edge, and those seen edge-on.
//
// By turns. From one node's boxes to the next node there is a chain of some fifty cycles, and where the tree exceeds the cache
// a fetch from memory: most of a ray's time. So a batch has two dozen rays on their way at a time, and each takes a step of the
// same kind before any takes another: a node, a block of triangles, or the next ray. While one ray waits for its node, the
// others have theirs; what kind of step comes next, which nobody can predict, is not asked by a branch. That is 1.1 to 1.9
// times as fast as ray by ray where the tree fits the cache, and 2 to 3 times where it does not, but for shadow rays that run
// nearly as the ones before.
//
// Rays that are few take their steps one ray after the other. There, branches choose the next node, so that a machine that
// predicts them begins with it at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/geometry/moeller_trumbore.h"
#include "libaccel/geometry/pluecker.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/geometry/woop.h"
#include "libaccel/structure/bvh8_coded.h"
#include "libaccel/trace/simd_batch.h"
#include "libaccel/trace/slabs.h"

namespace accel {

// The most inner nodes on a path from the root that are accepted, and what may be postponed on such a path: all children but
// one of each node, and all of the last; and room for a whole vector to be stored behind that.
inline constexpr std::uint32_t kMostBvh8Depth = 128;
constexpr std::uint32_t bvh8_stack_size(std::uint32_t depth) { return (kBvh8Arity - 1) * depth + 1 + kBvh8Arity; }

// Rays of a batch that go by turns: fewer would hardly wait less.
inline constexpr std::size_t kFewestInTurns = 8;

// The code for a tree.
template <class Node>
using Bvh8Functions = SimdFunctions<Bvh8ViewOf<Node>>;

// The functions for the best target that the machine has. A source each for the other box tests (bvh8_simd_slabs.cpp), node
// layouts (bvh8_simd_coded.cpp, bvh8_simd_compact.cpp) and triangle tests (bvh8_simd_tests.cpp), each with all else as by
// default.
template <class Node, class Slabs, class Test>
struct Bvh8Simd;

template <>
struct Bvh8Simd<Bvh8Node, PaddedSlabs, Watertight> {
  static Bvh8Functions<Bvh8Node> functions();
};
template <>
struct Bvh8Simd<Bvh8Node, NaiveSlabs, Watertight> {
  static Bvh8Functions<Bvh8Node> functions();
};
template <>
struct Bvh8Simd<Bvh8Node, FusedSlabs, Watertight> {
  static Bvh8Functions<Bvh8Node> functions();
};
template <>
struct Bvh8Simd<ByteBvh8Node, PaddedSlabs, Watertight> {
  static Bvh8Functions<ByteBvh8Node> functions();
};
template <>
struct Bvh8Simd<HalfBvh8Node, PaddedSlabs, Watertight> {
  static Bvh8Functions<HalfBvh8Node> functions();
};
template <>
struct Bvh8Simd<CompactBvh8Node, PaddedSlabs, Watertight> {
  static Bvh8Functions<CompactBvh8Node> functions();
};
template <>
struct Bvh8Simd<Bvh8Node, PaddedSlabs, MoellerTrumbore> {
  static Bvh8Functions<Bvh8Node> functions();
};
template <>
struct Bvh8Simd<Bvh8Node, PaddedSlabs, Woop> {
  static Bvh8Functions<Bvh8Node> functions();
};
template <>
struct Bvh8Simd<Bvh8Node, PaddedSlabs, WoopKahan> {
  static Bvh8Functions<Bvh8Node> functions();
};
template <>
struct Bvh8Simd<Bvh8Node, PaddedSlabs, Pluecker> {
  static Bvh8Functions<Bvh8Node> functions();
};

// The tree is no deeper than kMostBvh8Depth. answers[i] is that of rays[i].
template <class Node, class Slabs, class Test>
void trace_bvh8_simd(const Bvh8ViewOf<Node>& view, std::span<const Ray> rays, std::span<Hit> hits) {
  Bvh8Simd<Node, Slabs, Test>::functions().closest(view, rays.data(), rays.size(), hits.data());
}
template <class Node, class Slabs, class Test>
void trace_bvh8_simd(const Bvh8ViewOf<Node>& view, std::span<const Ray> rays, std::span<std::uint8_t> occluded) {
  Bvh8Simd<Node, Slabs, Test>::functions().occluded(view, rays.data(), rays.size(), occluded.data());
}

// The name of the target that runs: "AVX3" and so on.
const char* bvh8_simd_target();

}  // namespace accel
