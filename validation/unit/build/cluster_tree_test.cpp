// The steps of FastWideBvh: order, leaves and merging.
#include "libaccel/build/cluster_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "libaccel/build/curve_leaves.h"
#include "libaccel/build/curve_order.h"
#include "libaccel/build/sah_bins.h"
#include "libaccel/core/morton.h"
#include "libaccel/structure/triangle_block.h"
#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

// A mesh up to its leaves, each step there to be looked at.
struct Steps {
  explicit Steps(const TriangleMesh& mesh, std::uint32_t most = kBlockLanes) : context(mesh, options) {
    const References references = make_sparse_references(context);
    bounds = references.bounds;
    const CurveOrder order = curve_order(context, references);
    sorted = in_order(references, order);
    tree = cut_into_leaves(context, references, order, most);
  }
  void merge() {
    ProgressMeter progress(options.progress, "merge", tree.leaves);
    merge_clusters(context, tree, bounds.boxes, progress);
  }

  BuildOptions options;
  BuildContext context;
  SetBounds bounds;
  Buffer<Reference> sorted;
  ClusterTree tree;
};

std::uint64_t exact_code(const Reference& reference, const SetBounds& bounds) {
  const Vec3 centre = doubled_center(reference.box()).xyz(), lo = bounds.centers.lo.xyz();
  const Vec3 extent = (bounds.centers.hi - bounds.centers.lo).xyz();
  const float widest = std::max({extent.x, extent.y, extent.z});
  std::uint64_t code = 0;
  for (int a = 0; a < 3; ++a) {
    const double cell = widest > 0 ? (static_cast<double>(centre[a]) - lo[a]) / widest * (1 << 21) : 0;
    code |= spread_3(static_cast<std::uint32_t>(std::min(cell, (1 << 21) - 1.0))) << a;
  }
  return code;
}

TEST(CurveOrder, EveryTriangleOnceAlongTheCurve) {
  for (const auto& [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    const Steps steps(mesh);
    std::set<std::uint32_t> seen;
    std::uint64_t last = 0;
    int backward = 0;
    for (const Reference& reference : steps.sorted) {
      EXPECT_TRUE(seen.insert(reference.prim_id).second);
      const std::uint64_t code = exact_code(reference, steps.bounds);
      backward += code < last ? 1 : 0;
      last = code;
    }
    EXPECT_EQ(seen.size(), steps.context.report.triangles);
    EXPECT_LE(backward, static_cast<int>(steps.sorted.size() / 50));  // where single precision rounds to another cell
  }
}

// How far it is along an array, from box to box.
template <class Array>
double path_length(const Array& references, std::size_t begin, std::size_t end) {
  double path = 0;
  for (std::size_t i = begin + 1; i < end; ++i) {
    const Vec3 step = references[i].lo - references[i - 1].lo;
    path += std::abs(step.x) + std::abs(step.y) + std::abs(step.z);
  }
  return path;
}

// A hundred thousand times smaller than the scene: only the low bits tell its triangles apart.
TEST(CurveOrder, ATeapotInAStadiumIsInOrder) {
  TriangleMesh mesh = test::soup(5001, 0.1f);
  for (Vec3& v : mesh.vertices) v = 1e-2f * v;
  mesh.vertices[0] = {900, 900, 900}, mesh.vertices[1] = {901, 900, 900}, mesh.vertices[2] = {900, 901, 900};
  const Steps steps(mesh);
  BuildContext context(mesh, steps.options);
  const References unsorted = make_references(context, 0);
  EXPECT_LT(path_length(steps.sorted, 0, 5000), 0.2 * path_length(unsorted.storage, 1, 5001));
}

// Of all ways to cut a short curve, none is cheaper than the one that is found.
class EveryCut {
 public:
  explicit EveryCut(const Steps& steps) : steps_(steps), scale_(unit_scale(steps.bounds.boxes)) {}
  double least(std::size_t begin) const {
    const std::size_t left = steps_.sorted.size() - begin;
    if (left == 0) return 0;
    double cost = std::numeric_limits<double>::infinity();
    for (std::size_t k = 1; k <= std::min<std::size_t>(left, kBlockLanes); ++k)
      cost = std::min(cost, of_leaf(begin, begin + k) + least(begin + k));
    return cost;
  }
  double of_leaf(std::size_t begin, std::size_t end) const {
    return area(begin, end) + area(begin, std::min<std::size_t>(begin + kBlockLanes, steps_.sorted.size()));
  }

 private:
  double area(std::size_t begin, std::size_t end) const {
    return bounds_of(steps_.sorted.data(), begin, end).boxes.half_area(scale_);
  }
  const Steps& steps_;
  Float4 scale_;
};

TEST(CurveLeaves, NoCutIsCheaper) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Steps steps(test::soup(14, seed % 2 == 0 ? 0.1f : 1.0f, seed));
    const EveryCut cuts(steps);
    double cost = 0;
    for (std::size_t i = 0; i < steps.tree.leaves; ++i) {
      const Cluster& leaf = steps.tree.clusters[i];
      cost += cuts.of_leaf(leaf.first, leaf.first + leaf.second);
    }
    EXPECT_NEAR(cost, cuts.least(0), 1e-5 * cost);
  }
}

TEST(CurveLeaves, RunsFollowEachOther) {
  for (const std::uint32_t most : {1u, 3u, 4u})
    for (const std::size_t size : {1, 7, 20000}) {
      const Steps steps(test::soup(size, 0.1f), most);
      std::uint32_t next = 0;
      for (std::size_t i = 0; i < steps.tree.leaves; ++i) {
        const Cluster& leaf = steps.tree.clusters[i];
        EXPECT_EQ(leaf.first, next);
        EXPECT_TRUE(leaf.second >= 1 && leaf.second <= most);
        next += leaf.second;
        const Aabb box = bounds_of(steps.sorted.data(), leaf.first, next).boxes.aabb();
        EXPECT_TRUE(leaf.bounds().contains(box) && box.contains(leaf.bounds()));
      }
      EXPECT_EQ(next, size);
    }
}

TEST(ClusterTree, EveryClusterHasOneParentAndItsChildrensBox) {
  for (const auto& [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    Steps steps(mesh);
    steps.merge();
    const ClusterTree& tree = steps.tree;
    const std::size_t root = 2 * tree.leaves - 2;
    EXPECT_EQ(tree.rounds.back(), root + 1);
    std::vector<int> parents(root + 1);
    for (std::size_t round = 0; round + 1 < tree.rounds.size(); ++round)
      for (std::size_t i = tree.rounds[round]; i < tree.rounds[round + 1]; ++i) {
        const Cluster& node = tree.clusters[i];
        Aabb box;
        for (const std::uint32_t child : {node.first, node.second}) {
          ASSERT_LT(child, tree.rounds[round]);  // of an earlier round
          ++parents[child];
          box.extend(tree.clusters[child].bounds());
        }
        EXPECT_TRUE(node.bounds().contains(box) && box.contains(node.bounds()));
      }
    EXPECT_EQ(std::count(parents.begin(), parents.end(), 1), static_cast<std::ptrdiff_t>(root));
    EXPECT_EQ(parents[root], 0);
  }
}

// Triangles of which each prefers the one before: were only pairs that choose each other merged, a round would merge one.
TriangleMesh growing(std::size_t n) {
  std::vector<Triangle> triangles;
  float x = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const float size = 1e-3f * (1.0f + 1e-3f * static_cast<float>(i));
    triangles.push_back({{x, 0, 0}, {x + size, 0, 0}, {x, size, 0.5f * size}});
    x += size;
  }
  return test::mesh_of(triangles);
}

TEST(ClusterTree, RoundsAreFewForAnyInput) {
  for (const TriangleMesh& mesh : {test::identical(20000), growing(20000), test::flat_grid(100)}) {
    Steps steps(mesh);
    steps.merge();
    EXPECT_LE(steps.tree.rounds.size(), 75u);  // ln 20000 / ln (8 / 7)
  }
}

}  // namespace
}  // namespace accel
