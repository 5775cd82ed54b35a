// Sets of references, their events and their splits, against what can be said about them in O(n^2).
#include "libaccel/build/kdtree_split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "libaccel/build/kdtree_sort.h"

#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

constexpr KdCosts kCosts{.traversal = 1.0, .intersection = 1.5, .leaf = 2.5, .empty_bonus = 0.2};

TEST(KdEvents, OrderIsPositionThenEndsBeforeStartsThenReferences) {
  const KdEvent ordered[] = {{-1.0f, 5},  {-1.0f, KdEvent::kStart | 3}, {0.0f, 1}, {0.0f, 2}, {0.0f, KdEvent::kStart},
                             {1e-45f, 0}, {3e38f, KdEvent::kStart}};
  for (std::size_t i = 0; i < std::size(ordered); ++i)
    for (std::size_t j = 0; j < std::size(ordered); ++j) EXPECT_EQ(ordered[i] < ordered[j], i < j);

  KdEvent events[2];
  KdEventList list{events};
  list.append(-0.0f, -0.0f, -1.0f, 1.0f, 7);
  EXPECT_FALSE(std::signbit(events[0].position) || std::signbit(events[1].position));
  EXPECT_TRUE(events[0].is_start() && !events[1].is_start());
  EXPECT_EQ(events[0].reference(), 7u);
}

// Few events are compared, many go by digits.
TEST(KdEvents, SortedByDigitsAsByComparison) {
  for (const std::uint32_t count : {0u, 1u, 50u, 2047u, 2048u, 30000u}) {
    std::vector<KdEvent> events;
    for (std::uint32_t i = 0; events.size() < count; ++i) {
      CounterRng rng(5, i);
      // Both signs, many exponents, and many equal positions.
      const float position = std::ldexp(rng.next_float(-1, 1), static_cast<int>(rng.next_below(200)) - 100);
      const float coarse = std::floor(rng.next_float(-9, 9));
      events.push_back({(i % 2 == 0 ? position : coarse) + 0.0f, i | KdEvent::kStart});
      if (events.size() < count) events.push_back({coarse + 0.0f, i});
    }
    std::vector<KdEvent> expected = events;
    std::sort(expected.begin(), expected.end());
    MemoryMeter meter;
    ScratchStack scratch(meter);
    sort_events(events.data(), count, scratch);
    EXPECT_EQ(events, expected);
  }
}

TEST(KdEvents, InsertAndMergeKeepListsSorted) {
  constexpr std::uint32_t kCount = 100;
  std::vector<KdEvent> all(2 * kCount), one_by_one(2 * kCount), old(4 * kCount), added(2 * kCount);
  KdEventList expected{all.data()}, inserted{one_by_one.data()}, merged{old.data()}, rest{added.data()};
  for (std::uint32_t i = 0; i < kCount; ++i) {
    CounterRng rng(6, i);
    const float lo = std::floor(rng.next_float(0, 9)), hi = lo + 1 + std::floor(rng.next_float(0, 5));
    expected.append(lo, hi, 0, 9, i);
    inserted.insert(lo, hi, 0, 9, i);
    (i % 3 == 0 ? rest : merged).append(lo, hi, 0, 9, i);
  }
  for (const KdEventList& list : {expected, merged, rest}) std::sort(list.events, list.events + list.size);
  merge_events(merged, rest);
  for (const KdEventList& list : {inserted, merged}) {
    ASSERT_EQ(list.size, expected.size);
    EXPECT_EQ(list.starts, expected.starts);
    EXPECT_TRUE(std::equal(list.events, list.events + list.size, expected.events));
  }
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
          const auto leaf_cost = [](std::uint32_t n) { return n == 0 ? 0.0 : kCosts.leaf + kCosts.intersection * n; };
          double cost = kCosts.traversal * half_area_in_double(set.cell) + half_area_in_double(lower) * leaf_cost(below) +
                        half_area_in_double(upper) * leaf_cost(above);
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
