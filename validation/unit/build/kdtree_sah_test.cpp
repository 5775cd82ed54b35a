// What the builder of kd-trees owes to its callers: kdtree_sah.h, kdtree.h and padding.h.
#include "libaccel/build/kdtree_sah.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/structure/kdtree_stats.h"
#include "libaccel/structure/padding.h"
#include "libaccel/trace/kdtree_stack.h"
#include "validation/unit/build/builder_checks.h"

namespace accel {
namespace {

Built<KdTree> build_kdtree(const TriangleMesh& mesh, const BuildOptions& options = {}) {
  return test::build<KdTreeSah>(mesh, options);
}

KdTree build_with(const TriangleMesh& mesh, const KdCosts& costs) {
  Result<Built<KdTree>> built = KdTreeSah::build(mesh, {}, costs);
  EXPECT_TRUE(built.ok()) << built.error().message;
  return std::move(built->structure);
}

// Planes that many triangles share: where ties and closed cells show.
TriangleMesh coplanar_stacks() {
  std::vector<Triangle> triangles;
  for (int i = 0; i < 1000; ++i) {
    CounterRng rng(21, static_cast<std::uint64_t>(i));
    const auto c = [&] { return static_cast<float>(rng.next_below(9)); };
    const auto z = static_cast<float>(rng.next_below(3));
    const float x0 = c(), y0 = c(), x1 = c(), y1 = c(), x2 = c(), y2 = c();
    triangles.push_back({{x0, y0, z}, {x1, y1, z}, {x2, y2, z}});
  }
  return test::mesh_of(triangles);
}

// A thousand squares in one plane, one above the other.
TriangleMesh thousand_planes() {
  std::vector<Triangle> triangles;
  for (int i = 0; i < 500; ++i) {
    triangles.push_back({{0, 0, 1}, {4, 0, 1}, {4, 4, 1}});
    triangles.push_back({{0, 0, 1}, {4, 4, 1}, {0, 4, 1}});
  }
  triangles.push_back({{0, 0, 0}, {4, 0, 0}, {4, 4, 2}});
  return test::mesh_of(triangles);
}

// A room with a few small things in the middle.
TriangleMesh furnished_room(int things) {
  std::vector<Triangle> triangles;
  for (int i = 0; i < things; ++i) {
    const float x = 5 + 0.01f * static_cast<float>(i);
    triangles.push_back({{x, 5, 5}, {x, 5.02f, 5}, {x, 5, 5.02f}});
  }
  for (const float z : {0.0f, 10.0f}) {
    triangles.push_back({{0, 0, z}, {10, 0, z}, {10, 10, z}});
    triangles.push_back({{0, 0, z}, {10, 10, z}, {0, 10, z}});
  }
  return test::mesh_of(triangles);
}

TriangleMesh scaled(const TriangleMesh& mesh, float scale, float offset) {
  TriangleMesh result = mesh;
  result.vertices = Buffer<Vec3>::copy_of(mesh.vertices.span());
  for (Vec3& v : result.vertices) v = v * scale + Vec3{offset, -offset, 2 * offset};
  return result;
}

std::vector<test::NamedMesh> meshes() {
  std::vector<test::NamedMesh> result = test::all_meshes();
  result.push_back({"coplanar", coplanar_stacks()});
  result.push_back({"thousand planes", thousand_planes()});
  result.push_back({"tiny", scaled(test::soup(400, 0.3f), 0x1p-120f, 0)});
  result.push_back({"huge", scaled(test::soup(400, 0.3f), 0x1p59f, 0)});
  result.push_back({"far away", scaled(test::soup(400, 0.3f), 1, 20000)});
  result.push_back({"lost in rounding", scaled(test::soup(200, 0.3f), 1, 0x1p22f)});
  return result;
}

// Whether a closed triangle and a closed box have a common point: separating axes, Akenine-Moeller 2001. In 64 bits of
// precision: what is decided wrongly is wrong by less than the slack of the builder.
class TriangleBoxOverlap {
 public:
  TriangleBoxOverlap(const Triangle& t, const Aabb& cell, const Vec3d& pad, int pads) {
    const double pad_of[3] = {pad.x, pad.y, pad.z};
    const Vec3 vertices[3] = {t.v0, t.v1, t.v2};
    for (int a = 0; a < 3; ++a) {
      const long double lo = cell.lo[a] - static_cast<long double>(pads * pad_of[a]),
                        hi = cell.hi[a] + static_cast<long double>(pads * pad_of[a]);
      half_[a] = (hi - lo) / 2;
      for (int v = 0; v < 3; ++v) vertex_[v][a] = vertices[v][a] - (hi + lo) / 2;
    }
  }

  bool overlap() const {
    std::array<Axis, 3> edges;
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 3; ++a) edges[i][a] = vertex_[(i + 1) % 3][a] - vertex_[i][a];
    if (separates(cross(edges[0], edges[1]))) return false;
    for (int a = 0; a < 3; ++a) {
      Axis unit{};
      unit[a] = 1;
      if (separates(unit)) return false;
      for (const Axis& edge : edges)
        if (separates(cross(unit, edge))) return false;
    }
    return true;
  }

 private:
  using Axis = std::array<long double, 3>;
  static Axis cross(const Axis& p, const Axis& q) {
    return {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
  }
  bool separates(const Axis& axis) const {
    long double lo = INFINITY, hi = -INFINITY, radius = 0;
    for (const Axis& v : vertex_) {
      const long double at = v[0] * axis[0] + v[1] * axis[1] + v[2] * axis[2];
      lo = std::min(lo, at), hi = std::max(hi, at);
    }
    for (int a = 0; a < 3; ++a) radius += half_[a] * std::abs(axis[a]);
    return lo > radius || hi < -radius;
  }

  std::array<Axis, 3> vertex_;  // from the box's centre
  Axis half_;
};

struct LeafCell {
  Aabb cell;
  std::set<std::uint32_t> prim_ids;
};

std::vector<LeafCell> leaf_cells(const KdTree& tree) {
  struct Visit {
    std::uint32_t index;
    Aabb cell;
  };
  std::vector<LeafCell> result;
  std::vector<Visit> pending;
  if (!tree.nodes.empty()) pending.push_back({kKdRoot, tree.bounds});
  while (!pending.empty()) {
    const Visit visit = pending.back();
    pending.pop_back();
    const KdNode node = tree.nodes[visit.index];
    if (!node.is_leaf()) {
      Visit lower{node.lower_child(), visit.cell}, upper{node.lower_child() + 1, visit.cell};
      lower.cell.hi[node.axis()] = upper.cell.lo[node.axis()] = node.plane();
      pending.push_back(lower), pending.push_back(upper);
      continue;
    }
    LeafCell leaf{visit.cell, {}};
    for (std::uint32_t r = node.first_reference(); r != kEmptyLeaf; ++r) {
      const std::uint32_t reference = tree.leaves.references[r];
      leaf.prim_ids.insert(tree.leaves.triangles[slot_of(reference)].prim_id());
      if (is_last(reference)) break;
    }
    result.push_back(leaf);
  }
  return result;
}

// As kdtree_plane.h has it, with empty leaves free.
double expected_cost(const KdTree& tree, const KdCosts& costs) {
  double cost = costs.traversal * kdtree_stats(tree).expected_steps;
  for (const LeafCell& leaf : leaf_cells(tree))
    cost += costs.of_leaf(static_cast<double>(leaf.prim_ids.size())) * half_area_in_double(leaf.cell) /
            half_area_in_double(tree.bounds);
  return cost;
}

TEST(KdTreeSah, NothingToBuildIsAnEmptyTree) {
  for (const TriangleMesh& mesh : test::empty_meshes()) {
    const Built<KdTree> built = build_kdtree(mesh);
    EXPECT_TRUE(built.structure.nodes.empty());
    EXPECT_EQ(built.report.skipped.zero_area, mesh.size());
  }
}

TEST(KdTreeSah, ReportAgreesWithTheTree) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    const Built<KdTree> built = build_kdtree(mesh);
    const KdTreeStats stats = kdtree_stats(built.structure);
    test::expect_true_report(mesh, built, stats);
    const Aabb bounds = mesh_facts(mesh).bounds;
    EXPECT_TRUE(built.structure.bounds.contains(padded(bounds, cell_padding(bounds))));
  }
}

// The law that traversers rely on: a triangle is in every leaf whose cell comes within pad of it.
TEST(KdTreeSah, TrianglesAreInEveryCellWithinThePad) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    const std::vector<LeafCell> leaves = leaf_cells(build_kdtree(mesh).structure);
    const Vec3d pad = cell_padding(mesh_facts(mesh).bounds);
    std::size_t missing = 0;
    for (std::uint32_t i = 0; i<mesh.size(); i += mesh.size()> 2000 ? 5 : 1) {
      const Triangle triangle = mesh.triangle(i);
      if (!is_in_range(triangle) || is_zero_area(triangle)) continue;
      const Aabb box = padded(padded(triangle.bounds(), pad), pad);
      for (const LeafCell& leaf : leaves) {
        if (intersection(box, leaf.cell).empty()) continue;
        missing += TriangleBoxOverlap(triangle, leaf.cell, pad, 1).overlap() && !leaf.prim_ids.contains(i);
      }
    }
    EXPECT_EQ(missing, 0u);
  }
}

// "Perfect" splits: no triangle is in a cell that it does not come near.
TEST(KdTreeSah, CellsHoldOnlyTrianglesNearThem) {
  for (const auto& [name, mesh] : meshes()) {
    if (name == "lost in rounding") continue;  // boxes are rounded outwards by more than the pad
    SCOPED_TRACE(name);
    const Vec3d pad = cell_padding(mesh_facts(mesh).bounds);
    std::size_t strangers = 0, references = 0;
    for (const LeafCell& leaf : leaf_cells(build_kdtree(mesh).structure))
      for (const std::uint32_t i : leaf.prim_ids)
        ++references, strangers += !TriangleBoxOverlap(mesh.triangle(i), leaf.cell, pad, 3).overlap();
    EXPECT_EQ(strangers, 0u) << "of " << references;
  }
}

TEST(KdTreeSah, HitsAreThoseOfBruteForce) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    const KdTree tree = build_kdtree(mesh).structure;
    test::expect_hits_of_brute_force<KdTreeStack<Watertight, Query::closest>>(mesh, tree, tree.bounds, 200);
  }
}

TEST(KdTreeSah, BytesDoNotDependOnThreads) { test::expect_same_bytes_for_any_threads<KdTreeSah>(test::soup(40000, 0.03f)); }

TEST(KdTreeSah, DepthStaysWithinItsBound) {
  for (const auto& [name, mesh] : meshes())
    for (const int max_depth : {0, 1, 5, 12, 1000}) {
      SCOPED_TRACE(name + ", " + std::to_string(max_depth));
      BuildOptions options;
      options.max_depth = max_depth;
      const Built<KdTree> built = build_kdtree(mesh, options);
      EXPECT_LE(built.structure.depth, static_cast<std::uint32_t>(std::min(max_depth, kKdStackSize)));
    }
}

TEST(KdTreeSah, ReferencesStayWithinTheBudget) {
  double last = 0;
  for (const float most : {1.0f, 1.5f, 3.0f, 8.0f}) {
    BuildOptions options;
    options.max_references = most;
    const Built<KdTree> built = build_kdtree(test::slivers(2000), options);
    EXPECT_LE(static_cast<double>(built.report.references), most * 2000.0);
    EXPECT_GT(static_cast<double>(built.report.references), last);
    last = static_cast<double>(built.report.references);
  }
}

TEST(KdTreeSah, CoincidentTrianglesShareALeaf) {
  const Built<KdTree> built = build_kdtree(test::identical(20000));
  EXPECT_LE(built.report.references, 10 * 20000u);
  EXPECT_LE(kdtree_stats(built.structure).leaves, 200u);
}

TEST(KdTreeSah, CheaperNodesMakeLargerTrees) {
  std::uint64_t last = 0;
  for (const float traversal_cost : {8.0f, 2.0f, 0.5f}) {
    BuildOptions options;
    options.traversal_cost = traversal_cost;
    const std::uint64_t inner_nodes = kdtree_stats(build_kdtree(test::soup(3000, 0.05f), options).structure).inner_nodes;
    EXPECT_GT(inner_nodes, last);
    last = inner_nodes;
  }
}

TEST(KdTreeSah, TheBonusCutsOffEmptySpace) {
  const auto empty_leaves = [](float bonus) {
    BuildOptions options;
    options.empty_bonus = bonus;
    const KdTreeStats stats = kdtree_stats(build_kdtree(test::soup(3000, 0.05f), options).structure);
    return static_cast<double>(stats.empty_leaves) / static_cast<double>(stats.leaves);
  };
  EXPECT_GT(empty_leaves(0.5f), empty_leaves(0.0f));
}

// Where no plane pays, some may do so together; those that do not are taken back: no tree is dearer, some are the same.
TEST(KdTreeSah, LooksFurtherWhereALeafIsDear) {
  constexpr KdCosts kGreedy{.traversal = 1.5, .intersection = 1, .leaf = 2, .empty_bonus = 0};
  KdCosts looks_further = kGreedy;
  looks_further.dear_leaf = 0.003;
  std::vector<test::NamedMesh> all = meshes();
  for (int things = 0; things < 4; ++things) all.push_back({"room with " + std::to_string(things), furnished_room(things)});
  std::size_t cheaper = 0, same = 0;
  for (const auto& [name, mesh] : all) {
    SCOPED_TRACE(name);
    const KdTree greedy = build_with(mesh, kGreedy), further = build_with(mesh, looks_further);
    const double cost = expected_cost(further, kGreedy), greedy_cost = expected_cost(greedy, kGreedy);
    EXPECT_LE(cost, greedy_cost * (1 + 1e-9));
    cheaper += cost < 0.99 * greedy_cost;
    same += std::ranges::equal(greedy.nodes.span(), further.nodes.span(),
                               [](const KdNode& a, const KdNode& b) { return a.payload == b.payload && a.link == b.link; });
  }
  EXPECT_GE(cheaper, 3u);
  EXPECT_GE(same, 3u);
}

TEST(KdTreeSah, ScalingByAPowerOfTwoKeepsTheTree) {
  const TriangleMesh mesh = test::soup(1000, 0.2f);
  const KdTree a = build_kdtree(mesh).structure, b = build_kdtree(scaled(mesh, 0x1p40f, 0)).structure;
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].link, b.nodes[i].link);
    if (!a.nodes[i].is_leaf()) {
      EXPECT_EQ(a.nodes[i].plane() * 0x1p40f, b.nodes[i].plane());
    }
  }
}

TEST(KdTreeSah, ProgressCanInterrupt) { test::expect_progress_interrupts<KdTreeSah>(); }

TEST(KdTreeSah, MeaninglessOptionsAreRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto refuses = [](auto change) { return test::refuses<KdTreeSah>(change); };
  EXPECT_TRUE(refuses([&](BuildOptions& o) { o.empty_bonus = nan; }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.empty_bonus = 1; }));
  EXPECT_TRUE(refuses([&](BuildOptions& o) { o.max_references = nan; }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.max_references = 0.5f; }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.max_references = 1e9f; }));
}

}  // namespace
}  // namespace accel
