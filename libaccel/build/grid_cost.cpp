#include "libaccel/build/grid_cost.h"

#include <algorithm>
#include <cmath>

#include "libaccel/build/grid.h"
#include "libaccel/build/parallel.h"
#include "libaccel/core/vec3d.h"

namespace accel {
namespace {

// Candidates: this many numbers of cells while the number doubles.
constexpr int kCandidatesPerOctave = 16;

double surface(const double (&size)[3]) { return 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]); }

float doubled_center(const Aabb& box, int axis) { return box.lo[axis] + box.hi[axis]; }

// Between the doubled centres that leave out the tails.
struct Range {
  float lo = 0, hi = 0;
  bool contains(float x) const { return x >= lo && x <= hi; }
};

Range middle_of(Buffer<float>& centers) {
  const std::size_t tail = static_cast<std::size_t>(kGridCoreTail * static_cast<double>(centers.size()));
  float* const begin = centers.data();
  float* const end = begin + centers.size();
  float* const upper = end - 1 - tail;
  std::nth_element(begin, upper, end);
  std::nth_element(begin, begin + tail, upper + 1);
  return {begin[tail], *upper};
}

}  // namespace

GridCost::Sums& GridCost::Sums::operator+=(const Sums& other) {
  triangles += other.triangles;
  for (int a = 0; a < 3; ++a) width[a] += other.width[a], shadow[a] += other.shadow[a];
  return *this;
}

void GridCost::Sums::add(const Triangle& t) {
  const Aabb bounds = t.bounds();
  const Vec3d doubled_area = cross(Vec3d(t.v1) - Vec3d(t.v0), Vec3d(t.v2) - Vec3d(t.v0));
  const double doubled_shadow[3] = {doubled_area.x, doubled_area.y, doubled_area.z};
  triangles += 1;
  for (int a = 0; a < 3; ++a) {
    width[a] += static_cast<double>(bounds.hi[a]) - bounds.lo[a];
    shadow[a] += 0.5 * std::fabs(doubled_shadow[a]);
  }
}

double GridCost::Sums::references(const double (&planes)[3]) const {
  double sum = triangles;
  for (int a = 0; a < 3; ++a) sum += width[a] * planes[a] + shadow[a] * planes[(a + 1) % 3] * planes[(a + 2) % 3];
  return sum;
}

// The cells of a resolution.
struct GridCost::Cells {
  double planes[3];  // inner ones, a unit of length
  double size[3];

  Cells(const Part& box, const GridResolution& resolution) {
    for (int a = 0; a < 3; ++a) {
      planes[a] = box.size[a] > 0 ? (resolution[a] - 1) / box.size[a] : 0.0;
      size[a] = box.size[a] / resolution[a];
    }
  }
};

GridCost::GridCost(BuildContext& context, std::span<const PackedTriangle> triangles, const Aabb& bounds) : bounds_(bounds) {
  static_cast<Sums&>(box_) = reduce_chunks<Sums>(0, triangles.size(), [&](std::size_t b, std::size_t e) {
    Sums sums;
    for (std::size_t i = b; i < e; ++i) sums.add(triangles[i].vertices());
    return sums;
  });
  for (int a = 0; a < 3; ++a) box_.size[a] = static_cast<double>(bounds.hi[a]) - bounds.lo[a];
  core_ = make_core(context, triangles);
}

GridCost::Part GridCost::make_core(BuildContext& context, std::span<const PackedTriangle> triangles) const {
  const std::size_t bytes = 3 * triangles.size() * sizeof(float);
  context.memory.add(bytes);
  Range middle[3];
  for_each_axis(triangles.size(), [&](int a) {
    Buffer<float> centers(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) centers[i] = doubled_center(triangles[i].vertices().bounds(), a);
    middle[a] = middle_of(centers);
  });
  context.memory.subtract(bytes);

  Part core;
  static_cast<Sums&>(core) = reduce_chunks<Sums>(0, triangles.size(), [&](std::size_t b, std::size_t e) {
    Sums sums;
    for (std::size_t i = b; i < e; ++i) {
      const Triangle t = triangles[i].vertices();
      const Aabb box = t.bounds();
      if (middle[0].contains(doubled_center(box, 0)) && middle[1].contains(doubled_center(box, 1)) &&
          middle[2].contains(doubled_center(box, 2)))
        sums.add(t);
    }
    return sums;
  });

  // Each tail is less than a twentieth, so seven tenths of the triangles are in. The box is that of the centres, larger by the
  // mean size of the triangles, so that it has a surface even if they are all at one place.
  for (int a = 0; a < 3; ++a) {
    const double centers = 0.5 * (static_cast<double>(middle[a].hi) - middle[a].lo);
    core.size[a] = std::min(centers + core.width[a] / core.triangles, box_.size[a]);
  }
  return core;
}

double GridCost::references(const GridResolution& resolution) const { return box_.references(Cells(box_, resolution).planes); }

GridLineCost GridCost::through(const Part& part, const GridResolution& resolution) const {
  const Cells cells(box_, resolution);
  const double volume = part.size[0] * part.size[1] * part.size[2], area = surface(part.size);
  const double crossings = 2 * volume / area * (cells.planes[0] + cells.planes[1] + cells.planes[2]);
  return {1 + crossings, part.references(cells.planes) * std::min(1.0, surface(cells.size) / area)};
}

GridLineCost GridCost::through_box(const GridResolution& resolution) const { return through(box_, resolution); }
GridLineCost GridCost::through_core(const GridResolution& resolution) const { return through(core_, resolution); }

double GridCost::cost(const GridResolution& resolution, const BuildOptions& options) const {
  const auto of = [&](const GridLineCost& line) {
    return kGridStepCost * static_cast<double>(options.traversal_cost) * line.cells +
           static_cast<double>(options.intersection_cost) * line.tests;
  };
  return std::sqrt(of(through_box(resolution)) * of(through_core(resolution)));
}

double GridCost::cheapest_cells(const BuildOptions& options, double most_references) const {
  const double most = std::min(std::max(kMostCellsPerTriangle * box_.triangles, kFreeCells), double{kMaxGridCells / 2});
  double best_cells = 1, best_cost = cost({1, 1, 1}, options);
  for (int i = 1;; ++i) {
    const double cells = std::exp2(static_cast<double>(i) / kCandidatesPerOctave);
    if (!(cells <= most)) break;
    const GridResolution resolution = choose_grid_resolution(bounds_, cells);
    if (!(references(resolution) <= most_references)) continue;
    const double candidate = cost(resolution, options);
    if (candidate < best_cost) best_cells = cells, best_cost = candidate;
  }
  return best_cells;
}

}  // namespace accel
