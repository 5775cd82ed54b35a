#include "libaccel/trace/grid_dda.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "libaccel/build/grid.h"
#include "libaccel/core/counter_rng.h"
#include "libaccel/exec/drive.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/structure/padding.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

using Cells = std::vector<std::uint32_t>;

struct CellRecorder : NullObserver {
  Cells cells;
  std::uint32_t steps = 0, tests = 0;
  void leaf_visit(std::uint32_t cell) { cells.push_back(cell); }
  void node_step() { ++steps; }
  void triangle_test() { ++tests; }
};

template <class Mailbox>
using ClosestInGrid = GridTraverser<Watertight, Query::closest, Mailbox>;

// A grid without triangles, so that rays walk all the way.
struct EmptyGrid {
  explicit EmptyGrid(const GridFrame& grid_frame) : frame(grid_frame), cells(frame.resolution.cells(), kEmptyLeaf) {}
  GridView view() const { return {cells.data(), {}, frame}; }

  Cells cells_of(const Ray& ray) const {
    CellRecorder recorder;
    trace_ray<ClosestInGrid<NoMailbox>>(view(), ray, recorder);
    EXPECT_EQ(recorder.steps, recorder.cells.size()) << "one step leaves each cell";
    return recorder.cells;
  }
  std::uint32_t number(int x, int y, int z) const {
    return static_cast<std::uint32_t>((z * frame.resolution.y + y) * frame.resolution.x + x);
  }

  GridFrame frame;
  Cells cells;
};

// The cells of a ray by sorting all planes by their distance, for rays whose distances are exact in double. The first cell is,
// along each axis, the last one that starts no later than the interval, or the upper one if the ray runs in a plane; planes at
// the same distance are crossed x first.
Cells expected_cells(const EmptyGrid& grid, const Ray& ray) {
  struct Crossing {
    double t;
    int axis;
    bool leaves;  // the grid
    bool operator<(const Crossing& other) const { return t < other.t || (t == other.t && axis < other.axis); }
  };
  double t_enter = std::max(0.0f, ray.t_min), t_leave = ray.t_max;
  for (int a = 0; a < 3; ++a) {
    const double lo = grid.frame.plane(a, 0), hi = grid.frame.last_plane(a), org = ray.org[a], dir = ray.dir[a];
    if (dir == 0 && (org < lo || org > hi)) return {};
    if (dir == 0) continue;
    t_enter = std::max(t_enter, ((dir > 0 ? lo : hi) - org) / dir);
    t_leave = std::min(t_leave, ((dir > 0 ? hi : lo) - org) / dir);
  }
  if (t_enter > t_leave) return {};

  int index[3];
  std::vector<Crossing> crossings;
  for (int a = 0; a < 3; ++a) {
    const int n = grid.frame.resolution[a];
    const double dir = ray.dir[a];
    const auto plane = [&](int i) { return static_cast<double>(grid.frame.plane(a, static_cast<float>(i))); };
    index[a] = dir < 0 ? n - 1 : 0;
    for (int i = 1; i < n; ++i) {
      const double t = dir == 0 ? (plane(i) <= ray.org[a] ? -1.0 : 1e300) : (plane(i) - ray.org[a]) / dir;
      if (t <= t_enter)
        index[a] += dir < 0 ? -1 : 1;
      else if (dir != 0)
        crossings.push_back({t, a, false});
    }
    if (dir != 0) crossings.push_back({(plane(dir < 0 ? 0 : n) - ray.org[a]) / dir, a, true});
  }

  std::sort(crossings.begin(), crossings.end());
  Cells cells{grid.number(index[0], index[1], index[2])};
  for (const Crossing& c : crossings) {
    if (c.leaves || c.t > ray.t_max) break;
    index[c.axis] += ray.dir[c.axis] < 0 ? -1 : 1;
    cells.push_back(grid.number(index[0], index[1], index[2]));
  }
  return cells;
}

std::string text_of(const Ray& ray) {
  const auto text = [](Vec3 v) { return std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z); };
  return "org " + text(ray.org) + ", dir " + text(ray.dir) + ", t " + std::to_string(ray.t_min) + " to " +
         std::to_string(ray.t_max);
}

// Small dyadic numbers, so that all distances are exact in float: rays through corners and edges, in faces of cells and of the
// box, starting on borders, with zeros of both signs.
TEST(GridDda, VisitsTheCellsOfTheExactRay) {
  const EmptyGrid grids[] = {EmptyGrid({{0, 0, 0}, {1, 1, 1}, {4, 5, 3}}), EmptyGrid({{-2, -1, 1}, {0.5f, 1, 2}, {6, 3, 4}}),
                             EmptyGrid({{0, 0, 0}, {4, 4, 4}, {1, 1, 1}})};
  constexpr float kDirections[] = {0.0f, -0.0f, 1, -1, 2, -2, 0.5f, -0.25f};
  int walked = 0;
  for (const EmptyGrid& grid : grids)
    for (std::uint64_t i = 0; i < 40'000; ++i) {
      CounterRng rng(7, i);
      Ray ray;
      const auto back = static_cast<float>(rng.next_below(5));
      for (int a = 0; a < 3; ++a) {
        ray.dir[a] = kDirections[rng.next_below(8)];
        const auto halves = static_cast<std::uint32_t>(2 * grid.frame.bounds().extent()[a]);
        ray.org[a] = grid.frame.lo[a] + 0.5f * static_cast<float>(rng.next_below(halves + 1)) - back * ray.dir[a];
      }
      if (ray.dir.x == 0 && ray.dir.y == 0 && ray.dir.z == 0) continue;
      if (rng.next_below(3) == 0) ray.t_min = 0.5f * static_cast<float>(rng.next_below(8));
      if (rng.next_below(3) == 0) ray.t_max = ray.t_min + 0.5f * static_cast<float>(rng.next_below(8));
      const Cells cells = grid.cells_of(ray), expected = expected_cells(grid, ray);
      ASSERT_EQ(cells, expected) << text_of(ray);
      walked += cells.size() > 2;
    }
  EXPECT_GT(walked, 10'000);
}

// Any rays: every step goes to a neighbour, the cells lie along the ray within the padding, and none is left out that the ray
// passes well inside.
class RandomWalks : public testing::Test {
 protected:
  struct Slab {
    double enter, leave;
  };
  // When the ray is in a cell that is larger than itself by `margin` pads.
  static Slab slab(const GridFrame& frame, const Ray& ray, const int (&index)[3], const double (&pads)[3], double margin) {
    Slab result{std::max(0.0f, ray.t_min), ray.t_max};
    for (int a = 0; a < 3; ++a) {
      const double lo = frame.plane(a, static_cast<float>(index[a])) - margin * pads[a] - ray.org[a];
      const double hi = frame.plane(a, static_cast<float>(index[a] + 1)) + margin * pads[a] - ray.org[a];
      const double dir = ray.dir[a];
      if (dir == 0 && (lo > 0 || hi < 0)) return {1, 0};
      if (dir == 0) continue;
      result.enter = std::max(result.enter, (dir > 0 ? lo : hi) / dir);
      result.leave = std::min(result.leave, (dir > 0 ? hi : lo) / dir);
    }
    return result;
  }
};

TEST_F(RandomWalks, FollowTheRayWithinThePadding) {
  const EmptyGrid grid({{-1.1f, 0.3f, 1e3f}, {0.37f, 0.011f, 1.7f}, {9, 14, 11}});
  const Aabb bounds = grid.frame.bounds();
  const Vec3d pad = cell_padding(bounds);
  const double pads[3] = {pad.x, pad.y, pad.z};
  for (std::uint64_t i = 0; i < 3000; ++i) {
    CounterRng rng(8, i);
    Ray ray;
    for (int a = 0; a < 3; ++a) {
      ray.org[a] = bounds.lo[a] + rng.next_float(-2, 3) * bounds.extent()[a];
      const float target = rng.next_below(4) == 0 ? grid.frame.plane(a, static_cast<float>(rng.next_below(9)))
                                                  : bounds.lo[a] + rng.next_float() * bounds.extent()[a];
      ray.dir[a] = rng.next_below(8) == 0 ? 0.0f : target - ray.org[a];
    }
    if (!is_traceable(ray)) continue;
    const Cells cells = grid.cells_of(ray);
    std::vector<bool> visited(grid.cells.size());
    for (std::size_t k = 0; k < cells.size(); ++k) {
      visited[cells[k]] = true;
      if (k == 0) continue;
      const auto step = std::abs(static_cast<int>(cells[k]) - static_cast<int>(cells[k - 1]));
      EXPECT_TRUE(step == 1 || step == 9 || step == 9 * 14) << text_of(ray);
    }
    for (int z = 0; z < 11; ++z)
      for (int y = 0; y < 14; ++y)
        for (int x = 0; x < 9; ++x) {
          const int index[3] = {x, y, z};
          const Slab inner = slab(grid.frame, ray, index, pads, -1), outer = slab(grid.frame, ray, index, pads, 1);
          const bool was_visited = visited[grid.number(x, y, z)];
          EXPECT_TRUE(was_visited || !(inner.enter < inner.leave)) << text_of(ray);
          EXPECT_TRUE(!was_visited || outer.enter <= outer.leave) << text_of(ray);
        }
  }
}

// Planes of one axis that coincide, far from the origin: flat cells are walked through, and the walk ends.
TEST_F(RandomWalks, EndInFlatCells) {
  const EmptyGrid grid({{1e7f, 0, 0}, {0.125f, 1, 1}, {40, 2, 2}});
  ASSERT_EQ(grid.frame.plane(0, 1), grid.frame.plane(0, 2));
  for (const float dir : {1.0f, -1.0f, 1e-3f, -1e-3f, 1e-30f, 0.0f, -0.0f}) {
    for (const float x : {1e7f, 1e7f + 2, 1e7f - 100, 1e7f + 100}) {
      const Cells cells = grid.cells_of({.org = {x, -1, 0.5f}, .dir = {dir, 1, 0}});
      EXPECT_LE(cells.size(), 42u);
    }
  }
  EXPECT_GE(grid.cells_of({.org = {0, 0.5f, 0.5f}, .dir = {1, 0, 0}}).size(), 36u) << "those that are not behind the start";
}

// A guess of the first cell that is far off: the origin is so far away that the start of the interval is rounded by more than
// the whole grid.
TEST_F(RandomWalks, StartFromAnyDistance) {
  const EmptyGrid grid({{0, 0, 0}, {1, 1, 1}, {64, 64, 64}});
  for (const float distance : {1e3f, 1e6f, 1e9f, 1e12f, 1e18f})
    for (int axis = 0; axis < 3; ++axis)
      for (const float sign : {1.0f, -1.0f}) {
        Ray ray{.org = {32.5f, 32.5f, 32.5f}, .dir = {0, 0, 0}};
        ray.org[axis] = -sign * distance, ray.dir[axis] = sign;
        EXPECT_LE(grid.cells_of(ray).size(), 64u) << distance;
        EXPECT_GE(grid.cells_of(ray).size(), 1u) << distance;
        ray.dir[(axis + 1) % 3] = 1e-3f;
        EXPECT_LE(grid.cells_of(ray).size(), 128u) << distance;
      }
}

TEST(GridDdaWalk, EndsWhereTheIntervalEnds) {
  const EmptyGrid grid({{0, 0, 0}, {1, 1, 1}, {8, 1, 1}});
  const auto cells = [&](float t_min, float t_max) {
    return grid.cells_of({.org = {-1, 0.5f, 0.5f}, .t_min = t_min, .dir = {1, 0, 0}, .t_max = t_max}).size();
  };
  EXPECT_EQ(cells(0, kInfinity), 8u);
  EXPECT_EQ(cells(0, 3.5f), 3u);
  EXPECT_EQ(cells(0, 4.0f), 4u) << "a border belongs to both cells";
  EXPECT_EQ(cells(3.5f, 3.5f), 1u);
  EXPECT_EQ(cells(3.5f, 4.5f), 2u);
  EXPECT_EQ(cells(0, 0.5f), 0u) << "ends before the grid";
  EXPECT_EQ(cells(9.5f, kInfinity), 0u) << "starts behind it";
}

TEST(GridDdaWalk, NothingIsHitInAnEmptyScene) {
  CellRecorder recorder;
  EXPECT_FALSE(trace_ray<ClosestInGrid<NoMailbox>>(GridView{}, {.org = {0, 0, 0}, .dir = {1, 0, 0}}, recorder).valid());
  EXPECT_TRUE(recorder.cells.empty());
}

class GridMailbox : public testing::Test {
 protected:
  struct Answer {
    std::vector<Hit> hits;
    std::uint32_t tests = 0;
  };
  template <class Traverser>
  static Answer trace(const typename Traverser::View& view, const std::vector<Ray>& rays) {
    Answer answer;
    for (const Ray& ray : rays) {
      CellRecorder recorder;
      answer.hits.push_back(trace_ray<Traverser>(view, ray, recorder));
      answer.tests += recorder.tests;
    }
    return answer;
  }
  static bool same(const std::vector<Hit>& a, const std::vector<Hit>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Hit& p, const Hit& q) {
      return p.t == q.t && p.u == q.u && p.v == q.v && p.prim_id == q.prim_id;
    });
  }
};

// Large triangles in small cells: most tests would be repetitions.
TEST_F(GridMailbox, SavesTestsAndChangesNoHit) {
  for (const validation::StressScene& scene : validation::stress_scenes(9)) {
    SCOPED_TRACE(scene.name);
    Result<Built<Grid>> built = GridBuilder::build(scene.mesh, {});
    ASSERT_TRUE(built) << built.message();
    const std::vector<Ray> rays = validation::stress_rays(scene.mesh, 1000, 3);
    const GridView view = built->structure.view();
    const Answer none = trace<ClosestInGrid<NoMailbox>>(view, rays), one = trace<ClosestInGrid<Mailbox<1>>>(view, rays),
                 four = trace<ClosestInGrid<Mailbox<4>>>(view, rays), many = trace<ClosestInGrid<Mailbox<64>>>(view, rays);
    EXPECT_TRUE(same(none.hits, one.hits));
    EXPECT_TRUE(same(none.hits, four.hits));
    EXPECT_TRUE(same(none.hits, many.hits));
    EXPECT_LE(four.tests, none.tests);
    EXPECT_LE(many.tests, four.tests);
    EXPECT_TRUE(scene.name != "soup" || many.tests < none.tests * 3 / 4) << many.tests << " of " << none.tests;
    const auto any = trace<GridTraverser<Watertight, Query::any, Mailbox<4>>>(view, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(any.hits[i].valid(), none.hits[i].valid());
  }
}

}  // namespace
}  // namespace accel
