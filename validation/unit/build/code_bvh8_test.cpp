#include "libaccel/build/code_bvh8.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "libaccel/build/coded_wide_sbvh.h"
#include "libaccel/build/wide_sbvh.h"
#include "libaccel/core/counter_rng.h"
#include "libaccel/structure/bvh8_stats.h"
#include "libaccel/trace/bvh8_ordered.h"
#include "validation/stress/hostile_floats.h"
#include "validation/unit/build/builder_checks.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

template <class Node>
class CodeBvh8 : public testing::Test {};
using CodedNodes = testing::Types<ByteBvh8Node, HalfBvh8Node, CompactBvh8Node>;
TYPED_TEST_SUITE(CodeBvh8, CodedNodes);

// A tree of one node with the given boxes.
Bvh8 tree_of(const std::vector<Aabb>& boxes) {
  Bvh8 bvh;
  bvh.root = 0, bvh.depth = 1;
  bvh.nodes = Buffer<Bvh8Node>(1);
  bvh.nodes[0] = {};
  for (std::uint32_t c = 0; c < kBvh8Arity; ++c)
    if (c < boxes.size())
      bvh.nodes[0].set_child(c, block_ref(c, 1), boxes[c]);
    else
      bvh.nodes[0].set_child(c, kNoNode, {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}});
  for (const Aabb& box : boxes) bvh.bounds.extend(box);
  return bvh;
}

template <class Node>
void expect_contains(const Bvh8& exact) {
  const auto coded = code_bvh8<Node>(exact);
  ASSERT_EQ(coded.nodes.size(), exact.nodes.size());
  for (std::size_t n = 0; n < exact.nodes.size(); ++n)
    for (std::uint32_t c = 0; c < kBvh8Arity; ++c) {
      ASSERT_EQ(coded.nodes[n].child[c], exact.nodes[n].child[c]);
      ASSERT_EQ(coded.nodes[n].order[c], exact.nodes[n].order[c]);
      if (exact.nodes[n].child[c] == kNoNode)
        ASSERT_TRUE(coded.nodes[n].is_absent(c));
      else
        ASSERT_TRUE(coded.nodes[n].bounds(c).contains(exact.nodes[n].bounds(c))) << n << ", child " << c;
    }
}

// Coding costs time, never a hit.
TYPED_TEST(CodeBvh8, BoxesContainWhatTheyStandFor) {
  for (const auto& [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    expect_contains<TypeParam>(WideSbvh::build(mesh, {})->structure);
  }
}

// Frames of any size anywhere: tiny ones far away, where neighbouring codes are one float, flat ones, denormals, the limits.
TYPED_TEST(CodeBvh8, BoxesOfAnySizeAnywhere) {
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    CounterRng rng(11, i);
    const auto coordinate = [&](float center, int exponent) {
      const float x = center + std::ldexp(rng.next_float(-1, 1), exponent);
      return std::clamp(x, -kMaxCoordinate, kMaxCoordinate);
    };
    std::vector<Aabb> boxes(1 + rng.next_below(kBvh8Arity));
    for (int a = 0; a < 3; ++a) {
      const float center = rng.next_below(4) == 0 ? 0.0f : validation::random_over_exponents(rng, -149, 59);
      const int exponent = static_cast<int>(rng.next_below(205)) - 149;
      for (Aabb& box : boxes) {
        const float p = coordinate(center, exponent), q = rng.next_below(5) == 0 ? p : coordinate(center, exponent);
        box.lo[a] = std::min(p, q), box.hi[a] = std::max(p, q);
      }
    }
    expect_contains<TypeParam>(tree_of(boxes));
    if (this->HasFailure()) return;
  }
}

// As tight as the codes allow: a plane is off by less than two steps, and the frame by less than half of what it could be.
TYPED_TEST(CodeBvh8, BoxesAreTight) {
  const Bvh8 exact = WideSbvh::build(test::soup(3000, 0.05f), {})->structure;
  const auto coded = code_bvh8<TypeParam>(exact);
  const double step = sizeof(typename TypeParam::Code) == 1 ? 2.0 / 255 : 0x1p-9;
  for (std::size_t n = 0; n < exact.nodes.size(); ++n) {
    Aabb all;
    for (std::uint32_t c = 0; c < kBvh8Arity; ++c)
      if (exact.nodes[n].child[c] != kNoNode) all.extend(exact.nodes[n].bounds(c));
    for (std::uint32_t c = 0; c < kBvh8Arity; ++c)
      if (exact.nodes[n].child[c] != kNoNode)
        for (int a = 0; a < 3; ++a) {
          const double most = 2 * step * (static_cast<double>(all.hi[a]) - all.lo[a]) + 1e-6;
          EXPECT_LE(exact.nodes[n].bounds(c).lo[a] - coded.nodes[n].bounds(c).lo[a], most);
          EXPECT_LE(coded.nodes[n].bounds(c).hi[a] - exact.nodes[n].bounds(c).hi[a], most);
        }
  }
}

TYPED_TEST(CodeBvh8, DecodingIsExactArithmeticRoundedOnce) {
  TypeParam node{};
  node.origin[0] = 0.1f, node.exponent[0] = -7;
  for (std::uint32_t code = 0; code <= TypeParam::Coding::kMost; ++code) {
    if (sizeof(typename TypeParam::Code) == 2 && code > 0 && code < 0x400) continue;
    const auto c = static_cast<typename TypeParam::Code>(code);
    const double value = sizeof c == 1 ? code : std::ldexp(1024 + (code & 1023u), static_cast<int>(code >> 10) - 25);
    const double exact = static_cast<double>(node.origin[0]) + (code == 0 ? 0 : value) * 0x1p-7;
    ASSERT_EQ(node.decode(0, c), static_cast<float>(exact)) << code;
  }
}

TYPED_TEST(CodeBvh8, NothingStaysNothing) {
  const auto coded = code_bvh8<TypeParam>(Bvh8{});
  EXPECT_EQ(coded.root, kNoNode);
  EXPECT_TRUE(validate(coded, 0).ok());
}

template <class Builder, template <class, Query> class Traverser>
void expect_builds() {
  for (const auto& [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    const auto built = test::build<Builder>(mesh);
    EXPECT_TRUE(validate(built.structure, mesh.size()).ok());
    const Bvh8Stats stats = bvh8_stats(built.structure, 1, 1);
    test::expect_true_report(mesh, built, stats);
    EXPECT_EQ(built.report.phases.back().name.find("code boxes"), 0u);
    constexpr float kHalf = 2.0f / 3.0f;
    test::expect_hits_of_brute_force<Traverser<Watertight, Query::closest>>(
        mesh, built.structure, {{-kHalf, -kHalf, -kHalf}, {kHalf, kHalf, kHalf}}, 100);
  }
  test::expect_same_bytes_for_any_threads<Builder>(test::soup(70000, 0.05f));
}

TEST(CodedWideSbvh, Bytes) { expect_builds<ByteWideSbvh, Bvh8ByteOrdered>(); }
TEST(CodedWideSbvh, Halves) { expect_builds<HalfWideSbvh, Bvh8HalfOrdered>(); }
TEST(CodedWideSbvh, Compact) { expect_builds<CompactWideSbvh, Bvh8CompactOrdered>(); }

TEST(CodedWideSbvh, CompactTreesAreThoseOfBytes) {
  const TriangleMesh mesh = test::flat_grid(60);
  const auto bytes = ByteWideSbvh::build(mesh, {});
  const auto compact = CompactWideSbvh::build(mesh, {});
  const Bvh8Byte& a = bytes->structure;
  const Bvh8Compact& b = compact->structure;
  ASSERT_EQ(a.nodes.size_bytes(), b.nodes.size_bytes());
  EXPECT_EQ(std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size_bytes()), 0);
  EXPECT_EQ(a.root, b.root);
  EXPECT_EQ(a.references, b.references);
  EXPECT_LT(b.size_bytes(), a.size_bytes() * 2 / 3);
  EXPECT_EQ(compact->report.notes.size(), bytes->report.notes.size() + 1);
  EXPECT_EQ(compact->report.notes.back().what, "copies of vertices");
  EXPECT_EQ(compact->report.notes.back().why.find("merged by position: " + std::to_string(61 * 61) + " vertices"), 0u);
}

// Files may hold anything: frames that are not numbers and absent children with boxes are found.
TEST(ValidateCodedBvh8, FindsDamage) {
  const auto damaged = [](auto&& damage) {
    Bvh8Byte bvh = ByteWideSbvh::build(test::soup(300, 0.2f), {})->structure;
    damage(bvh);
    return !validate(bvh, 300).ok();
  };
  EXPECT_FALSE(damaged([](Bvh8Byte&) {}));
  EXPECT_TRUE(damaged([](Bvh8Byte& b) { b.nodes[0].origin[1] = std::nanf(""); }));
  EXPECT_TRUE(damaged([](Bvh8Byte& b) { std::swap(b.nodes[0].planes[2][0][0], b.nodes[0].planes[2][1][0]); }));
  EXPECT_TRUE(damaged([](Bvh8Byte& b) { b.nodes[0].child[0] = b.nodes[0].child[1]; }));
  EXPECT_TRUE(damaged([](Bvh8Byte& b) {
    for (ByteBvh8Node& node : b.nodes)
      if (node.child[kBvh8Arity - 1] == kNoNode) node.planes[0][1][kBvh8Arity - 1] = 255;
  }));
}

}  // namespace
}  // namespace accel
