// Sets of references, their events and their splits, against what can be said about them in O(n^2).
#include "libaccel/build/kdtree_split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

constexpr KdCosts kCosts{1.0, 1.5, 0.2};

TEST(KdEvents, KeysAreInTheOrderOfPositions) {
  const float positions[] = {-3e38f, -1.0f, -1e-45f, 0.0f, 1e-45f, 1.0f, 1.5f, 3e38f};
  for (const float a : positions) {
    EXPECT_EQ(position_of(make_event(a, 0, 7)), a);
    EXPECT_EQ(position_of(make_event(a, kStartOfReference, 7)), a);
    for (const float b : positions) {
      EXPECT_EQ(make_event(a, kStartOfReference, 1) < make_event(b, 0, 0), a < b);
    }
  }
  EXPECT_EQ(make_event(-0.0f, 0, 0), make_event(0.0f, 0, 0));
}

// The references and the events of a node, checked against each other and against the cheapest plane found the slow way; then
// the same for its children.
class SlowCheck {
 public:
  explicit SlowCheck(const TriangleMesh& mesh)
      : mesh_(mesh), splitter_(mesh, bounds_of(mesh)), memory_(meter_), scratch_(meter_) {
    std::vector<Reference> references;
    for (std::uint32_t i = 0; i < mesh.size(); ++i) {
      const Aabb box = mesh.triangle(i).bounds();
      references.push_back({box.lo, i, box.hi, 0});
    }
    root_ = splitter_.root_set(references.data(), references.size(), memory_);
    root_.limit = 20 * mesh.size();
    root_.levels = 30;
  }

  void run() { check(root_, 12); }
  int splits() const { return splits_; }

 private:
  static Aabb bounds_of(const TriangleMesh& mesh) {
    Aabb bounds;
    for (std::uint32_t i = 0; i < mesh.size(); ++i) bounds.extend(mesh.triangle(i).bounds());
    return bounds;
  }

  void check(const KdSet& set, int levels) {
    check_events(set);
    const KdPlane plane = cheapest_plane(set, kCosts);
    EXPECT_DOUBLE_EQ(plane.cost, slowest_cost(set));
    if (!plane.found() || levels == 0 || set.size < 2) return;
    ++splits_;
    KdSet children[2];
    const ScratchStack::Mark mark = memory_.mark();
    splitter_.split(set, plane, scratch_, memory_, memory_, children);
    EXPECT_EQ(children[0].limit + children[1].limit, set.limit);
    for (const KdSet& child : children) {
      EXPECT_LE(child.size, child.limit);
      EXPECT_EQ(child.levels, set.levels - 1);
      check(child, levels - 1);
    }
    memory_.release(mark);
  }

  static void check_events(const KdSet& set) {
    for (int a = 0; a < 3; ++a) {
      std::vector<KdEvent> events(2 * std::size_t{set.size});
      KdEventList expected{events.data()};
      for (std::uint32_t i = 0; i < set.size; ++i) {
        const Reference& r = set.references[i];
        EXPECT_TRUE(r.lo[a] < set.cell.hi[a] && r.hi[a] > set.cell.lo[a]);
        expected.append(r.lo[a], r.hi[a], set.cell.lo[a], set.cell.hi[a], i);
      }
      std::sort(expected.events, expected.events + expected.size);
      ASSERT_EQ(set.axis[a].size, expected.size);
      EXPECT_EQ(set.axis[a].starts, expected.starts);
      EXPECT_TRUE(std::equal(expected.events, expected.events + expected.size, set.axis[a].events));
    }
  }

  // The least cost of all planes, counting for each.
  static double slowest_cost(const KdSet& set) {
    double best = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a)
      for (std::uint32_t i = 0; i < set.size; ++i)
        for (const float position : {set.references[i].lo[a], set.references[i].hi[a]}) {
          if (!(position > set.cell.lo[a] && position < set.cell.hi[a])) continue;
          std::uint32_t below = 0, above = 0;
          for (std::uint32_t k = 0; k < set.size; ++k)
            below += set.references[k].lo[a]<position, above += set.references[k].hi[a]> position;
          if (std::uint64_t{below} + above > set.limit) continue;
          Aabb lower = set.cell, upper = set.cell;
          lower.hi[a] = upper.lo[a] = position;
          double cost = kCosts.traversal * half_area_in_double(set.cell) +
                        kCosts.intersection * (half_area_in_double(lower) * below + half_area_in_double(upper) * above);
          if (below == 0 || above == 0) cost *= 1 - kCosts.empty_bonus;
          best = std::min(best, cost);
        }
    return best;
  }

  const TriangleMesh& mesh_;
  MemoryMeter meter_;
  KdSplitter splitter_;
  ScratchStack memory_, scratch_;
  KdSet root_;
  int splits_ = 0;
};

TEST(KdSplitter, EventsStaySortedAndPlanesAreTheCheapest) {
  const TriangleMesh meshes[] = {test::soup(1, 0.5f), test::soup(2, 0.5f), test::soup(120, 0.3f), test::slivers(60),
                                 test::flat_grid(6),  test::identical(40), test::doubling(80),    test::soup(60, 2.0f)};
  for (const TriangleMesh& mesh : meshes) {
    SlowCheck check(mesh);
    check.run();
    // One triangle and coincident ones fill their cells: there are no planes to try.
    EXPECT_EQ(check.splits() > 0, mesh.size() > 1 && mesh.size() != 40);
  }
}

// A triangle whose box meets a cell that the triangle itself misses is dropped there.
TEST(KdSplitter, PartsThatVanishAreDropped) {
  const TriangleMesh mesh = test::mesh_of({{{0, 0, 0}, {8, 8, 0}, {8, 8, 1}}, {{0, 7, 0}, {1, 8, 0}, {0, 8, 1}}});
  MemoryMeter meter;
  ScratchStack memory(meter), scratch(meter);
  const KdSplitter splitter(mesh, {{0, 0, 0}, {8, 8, 1}});
  const Reference references[] = {{{0, 0, 0}, 0, {8, 8, 1}, 0}, {{0, 7, 0}, 1, {1, 8, 1}, 0}};
  KdSet root = splitter.root_set(references, 2, memory);
  root.limit = 100, root.levels = 10;
  KdSet halves[2], quarters[2];
  splitter.split(root, {0, 4.0f, 0.0}, scratch, memory, memory, halves);
  EXPECT_EQ(halves[0].size, 2u);
  EXPECT_EQ(halves[1].size, 1u);
  splitter.split(halves[0], {1, 6.0f, 0.0}, scratch, memory, memory, quarters);
  EXPECT_EQ(quarters[0].size, 1u);
  ASSERT_EQ(quarters[1].size, 1u);
  EXPECT_EQ(quarters[1].references[0].prim_id, 1u);
}

}  // namespace
}  // namespace accel
