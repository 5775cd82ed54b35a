#include "libaccel/build/grid.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <optional>

#include "libaccel/build/build_context.h"
#include "libaccel/build/grid_cost.h"
#include "libaccel/build/grid_overlap.h"
#include "libaccel/build/parallel.h"
#include "libaccel/build/references.h"
#include "libaccel/structure/padding.h"

namespace accel {
namespace {

// Triangles whose cells are enumerated by one task.
constexpr std::size_t kTrianglesPerTask = 512;

std::uint32_t fetch_add(std::uint32_t& counter, std::uint32_t amount) {
  return std::atomic_ref(counter).fetch_add(amount, std::memory_order_relaxed);
}

std::string text_of(const GridResolution& r) {
  return std::to_string(r.x) + " x " + std::to_string(r.y) + " x " + std::to_string(r.z);
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

// Planes from the lower corner of `bounds` to its upper corner or, by rounding, beyond.
GridFrame make_frame(const Aabb& bounds, const GridResolution& resolution) {
  GridFrame frame{bounds.lo, {}, resolution};
  for (int a = 0; a < 3; ++a) {
    const double extent = static_cast<double>(bounds.hi[a]) - bounds.lo[a];
    frame.cell_size[a] = round_up(extent / resolution[a]);
    while (frame.last_plane(a) < bounds.hi[a]) frame.cell_size[a] = next_up(frame.cell_size[a]);
  }
  return frame;
}

// One build, once the triangles are known.
class Build {
 public:
  Build(BuildContext& context, Buffer<PackedTriangle> triangles, const Aabb& bounds)
      : context_(context), bounds_(bounds), pad_(cell_padding(bounds)) {
    grid_.leaves.triangles = std::move(triangles);
    const double most =
        static_cast<double>(context.options.max_references) * static_cast<double>(grid_.leaves.triangles.size());
    const auto limit = static_cast<std::uint64_t>(std::min(most, static_cast<double>(kEmptyLeaf - 1)));
    most_references_ = std::max(limit, kFreeReferences);
  }

  Result<Grid> run() {
    if (Status status = context_.options.grid_resolution[0] > 0 ? count_as_told() : count_as_chosen(); !status)
      return status.error();
    if (Status status = fill(); !status) return status.error();
    return std::move(grid_);
  }

 private:
  Status count_as_told() {
    const auto& cells = context_.options.grid_resolution;
    const GridResolution resolution{cells[0], cells[1], cells[2]};
    const Result<bool> fits = count(resolution);
    if (!fits) return fits.error();
    if (*fits) return Done{};
    return Error{"a grid of " + text_of(resolution) + " cells holds more than " + std::to_string(most_references_) +
                 " references to the triangles; lower grid_resolution or raise max_references"};
  }

  // Halves the number of cells until the references fit: one cell holds each triangle once.
  Status count_as_chosen() {
    double cells = choose_cells();
    const GridResolution wanted = choose_grid_resolution(bounds_, cells);
    GridResolution resolution = wanted;
    for (;;) {
      const Result<bool> fits = count(resolution);
      if (!fits) return fits.error();
      if (*fits) break;
      const GridResolution last = resolution;
      while (resolution == last) resolution = choose_grid_resolution(bounds_, cells /= 2);
    }
    if (resolution != wanted)
      context_.report.notes.push_back({"a grid of " + text_of(wanted) + " cells",
                                       "made coarser, because its cells hold more than " + std::to_string(most_references_) +
                                           " references; raise max_references to allow them"});
    return Done{};
  }

  // As many as the density makes or, without one, as cost least.
  double choose_cells() {
    const auto triangles = static_cast<double>(grid_.leaves.triangles.size());
    const BuildOptions& options = context_.options;
    if (options.grid_density > 0) return static_cast<double>(options.grid_density) * triangles;
    context_.begin_phase("choose");
    const GridCost cost(context_, grid_.leaves.triangles.span(), bounds_);
    const double cells = cost.cheapest_cells(options, static_cast<double>(most_references_));
    const GridResolution resolution = choose_grid_resolution(bounds_, cells);
    const GridLineCost box = cost.through_box(resolution), core = cost.through_core(resolution);
    context_.report.notes.push_back({"a grid of " + text_of(resolution) + " cells",
                                     "chosen, " + number(static_cast<double>(resolution.cells()) / triangles) +
                                         " a triangle: the cheapest by expected cost; a line through the scene enters " +
                                         number(box.cells) + " cells and tests " + number(box.tests) +
                                         " triangles, one through its middle triangles " + number(core.cells) + " and " +
                                         number(core.tests)});
    return cells;
  }

  // Counts the references of each cell; false, with counts that mean nothing, if there are more than allowed.
  Result<bool> count(const GridResolution& resolution) {
    context_.begin_phase("count");
    release_cells();
    grid_.frame = make_frame(padded(bounds_, pad_), resolution);
    cells_.emplace(grid_.frame, pad_);
    counts_ = Buffer<std::uint32_t>(resolution.cells());
    context_.memory.add(counts_.size_bytes());
    for_each_chunk(0, counts_.size(),
                   [&](std::size_t, std::size_t b, std::size_t e) { std::fill(counts_.data() + b, counts_.data() + e, 0u); });

    std::atomic<std::uint64_t> references{0};
    const Status done = for_each_triangle("count", [&](const TriangleCells& cells, std::uint32_t) {
      std::uint64_t reached = 0;
      cells.for_each([&](std::uint32_t cell) { fetch_add(counts_[cell], 1), ++reached; });
      return references.fetch_add(reached, std::memory_order_relaxed) + reached <= most_references_;
    });
    if (!done) return done.error();
    references_ = references.load();
    return references_ <= most_references_;
  }

  void release_cells() {
    context_.memory.subtract(counts_.size_bytes());
    counts_ = {};
  }

  // Turns counts into the names of the cells and into cursors, then writes the references.
  Status fill() {
    context_.begin_phase("fill");
    grid_.cells = Buffer<std::uint32_t>(counts_.size());
    grid_.leaves.references = Buffer<std::uint32_t>(references_);
    context_.memory.add(grid_.cells.size_bytes() + grid_.leaves.references.size_bytes());
    context_.report.references = references_;
    name_cells();

    const Status done = for_each_triangle("fill", [&](const TriangleCells& cells, std::uint32_t slot) {
      cells.for_each([&](std::uint32_t cell) { grid_.leaves.references[fetch_add(counts_[cell], 1)] = slot; });
      return true;
    });
    if (!done) return done;
    finish_cells();
    return Done{};
  }

  // An exclusive scan: afterwards counts_ holds where each cell's references start, and cells their names.
  void name_cells() {
    std::vector<std::uint32_t> starts(chunk_count(counts_.size()) + 1);
    for_each_chunk(0, counts_.size(), [&](std::size_t chunk, std::size_t b, std::size_t e) {
      for (std::size_t cell = b; cell < e; ++cell) starts[chunk + 1] += counts_[cell];
    });
    for (std::size_t chunk = 1; chunk < starts.size(); ++chunk) starts[chunk] += starts[chunk - 1];
    for_each_chunk(0, counts_.size(), [&](std::size_t chunk, std::size_t b, std::size_t e) {
      std::uint32_t next = starts[chunk];
      for (std::size_t cell = b; cell < e; ++cell) {
        const std::uint32_t count = counts_[cell];
        grid_.cells[cell] = count > 0 ? next : kEmptyLeaf;
        counts_[cell] = next;
        next += count;
      }
    });
  }

  // Sorts the references of each cell, which end at its cursor, and marks the last.
  void finish_cells() {
    for_each_chunk(0, counts_.size(), [&](std::size_t, std::size_t b, std::size_t e) {
      std::uint32_t* const references = grid_.leaves.references.data();
      for (std::size_t cell = b; cell < e; ++cell) {
        if (grid_.cells[cell] == kEmptyLeaf) continue;
        std::sort(references + grid_.cells[cell], references + counts_[cell]);
        references[counts_[cell] - 1] |= kLastReference;
      }
    });
    release_cells();
  }

  // Calls body(cells of the triangle, slot) for all triangles, concurrently, until one call returns false.
  template <class Body>
  Status for_each_triangle(std::string_view phase, const Body& body) {
    const Buffer<PackedTriangle>& triangles = grid_.leaves.triangles;
    const std::size_t tasks = (triangles.size() + kTrianglesPerTask - 1) / kTrianglesPerTask;
    ProgressMeter progress(context_.options.progress, phase, triangles.size());
    std::atomic<bool> enough{false};
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
      if (enough.load(std::memory_order_relaxed) || progress.stopped()) return;
      const std::size_t begin = task * kTrianglesPerTask, end = std::min(begin + kTrianglesPerTask, triangles.size());
      for (std::size_t slot = begin; slot < end; ++slot)
        if (!body(TriangleCells(*cells_, triangles[slot].vertices()), static_cast<std::uint32_t>(slot))) enough = true;
      progress.advance(end - begin);
    });
    return progress.stopped() ? Status(Error{std::string(kInterrupted)}) : Status(Done{});
  }

  BuildContext& context_;
  const Aabb bounds_;  // of the triangles
  const Vec3d pad_;
  std::uint64_t most_references_;
  std::optional<GridCells> cells_;
  Buffer<std::uint32_t> counts_;  // by cell: references, then where the next one goes
  std::uint64_t references_ = 0;
  Grid grid_;
};

// All triangles that a ray can hit, in mesh order.
Buffer<PackedTriangle> pack_triangles(BuildContext& context, Aabb& bounds) {
  References references = make_references(context, 0);
  context.begin_phase("pack");
  Buffer<PackedTriangle> triangles(references.count);
  context.memory.add(triangles.size_bytes());
  for_each_chunk(0, references.count, [&](std::size_t, std::size_t b, std::size_t e) {
    for (std::size_t i = b; i < e; ++i) {
      const std::uint32_t prim_id = references.storage[i].prim_id;
      triangles[i] = pack(context.mesh.triangle(prim_id), prim_id);
    }
  });
  bounds = references.bounds.boxes.aabb();
  context.memory.subtract(references.storage.size_bytes());
  return triangles;
}

}  // namespace

GridResolution choose_grid_resolution(const Aabb& bounds, double cells) {
  const Vec3d size = Vec3d(bounds.hi) - Vec3d(bounds.lo);
  const double extent[3] = {size.x, size.y, size.z};
  const double wanted = std::clamp(cells, 1.0, static_cast<double>(kMaxGridCells / 2));

  // The edge of a cube of which `wanted` fill the axes that are longer than it.
  bool counts[3] = {extent[0] > 0, extent[1] > 0, extent[2] > 0};
  double edge = 0;
  for (bool changed = true; changed;) {
    int axes = 0;
    double volume = 1;
    for (int a = 0; a < 3; ++a)
      if (counts[a]) ++axes, volume *= extent[a];
    if (axes == 0) return {1, 1, 1};
    edge = std::pow(volume / wanted, 1.0 / axes);
    changed = false;
    for (int a = 0; a < 3; ++a)
      if (counts[a] && extent[a] < edge) counts[a] = false, changed = true;
  }
  const auto along = [&](int a) {
    return counts[a] ? static_cast<std::int32_t>(std::clamp(std::round(extent[a] / edge), 1.0, double{kMaxGridResolution})) : 1;
  };
  return {along(0), along(1), along(2)};
}

Result<Built<Grid>> GridBuilder::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return run_build<Grid>(mesh, options, [](BuildContext& context) -> Result<Grid> {
    Aabb bounds;
    Buffer<PackedTriangle> triangles = pack_triangles(context, bounds);
    if (triangles.empty()) return Grid{};
    return Build(context, std::move(triangles), bounds).run();
  });
}

}  // namespace accel
