// What every builder owes to its callers, whatever it builds (build/builder.h): checks for the tests of each.
#pragma once

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "libaccel/build/builder.h"
#include "libaccel/build/triangle_list.h"
#include "libaccel/exec/drive.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/structure/arrays.h"
#include "libaccel/trace/brute_force.h"
#include "validation/unit/build/test_meshes.h"

namespace accel::test {

// Builds, and proves that the structure is valid.
template <class Builder>
Built<typename Builder::Structure> build(const TriangleMesh& mesh, const BuildOptions& options = {}) {
  auto built = Builder::build(mesh, options);
  EXPECT_TRUE(built.ok()) << built.message();
  const Status valid = validate(built->structure, mesh.size());
  EXPECT_TRUE(valid.ok()) << valid.message();
  return std::move(*built);
}

// Everything that a file of the structure would hold.
template <StructureOfArrays Structure>
std::vector<std::string> bytes_of(const Structure& structure) {
  const typename Structure::Words& words = structure;
  std::vector<std::string> bytes = {{reinterpret_cast<const char*>(&words), sizeof words}};
  Structure::for_each_array(structure, [&](std::string_view, const auto& array) {
    bytes.emplace_back(reinterpret_cast<const char*>(array.data()), array.size_bytes());
  });
  return bytes;
}

template <StructureOfArrays Structure>
bool same_bytes(const Structure& a, const Structure& b) {
  return bytes_of(a) == bytes_of(b);
}

// The mesh should be above the sizes from which phases are parallel.
template <class Builder>
void expect_same_bytes_for_any_threads(const TriangleMesh& mesh) {
  const tbb::global_control more_threads(tbb::global_control::max_allowed_parallelism, 8);
  BuildOptions options;
  options.threads = 1;
  const auto one = build<Builder>(mesh, options);
  for (const int threads : {2, 3, 8}) {
    options.threads = threads;
    EXPECT_TRUE(same_bytes(one.structure, build<Builder>(mesh, options).structure)) << threads << " threads";
  }
}

// That the report counts what there is: of the mesh, and of the structure as its statistics have it.
template <class Structure, class Stats>
void expect_true_report(const TriangleMesh& mesh, const Built<Structure>& built, const Stats& stats) {
  const MeshFacts facts = mesh_facts(mesh);
  EXPECT_EQ(built.report.skipped.zero_area, facts.zero_area);
  EXPECT_EQ(built.report.skipped.out_of_range, facts.out_of_range);
  EXPECT_EQ(built.report.triangles, mesh.size() - facts.zero_area - facts.out_of_range);
  EXPECT_EQ(stats.triangles, built.report.triangles);
  EXPECT_EQ(stats.references, built.report.references);
  EXPECT_GE(built.report.peak_bytes, built.structure.size_bytes());
}

// Rays from in and around the box to near a vertex.
template <class Traverser, class Structure>
void expect_hits_of_brute_force(const TriangleMesh& mesh, const Structure& structure, const Aabb& box, std::uint32_t rays) {
  const auto list = build<ListBuilder>(mesh);
  NullObserver observer;
  for (std::uint32_t i = 0; i < rays; ++i) {
    CounterRng rng(5, i);
    Ray ray;
    ray.org = box.center() + 1.5f * random_point(rng) * box.extent();
    const Vec3 target = mesh.vertices[rng.next_below(static_cast<std::uint32_t>(mesh.vertices.size()))];
    ray.dir = target + 0.3f * random_point(rng) * box.extent() - ray.org;
    const Hit expected = trace_ray<BruteForce<Watertight, Query::closest>>(list.structure.view(), ray, observer);
    const Hit hit = trace_ray<Traverser>(structure.view(), ray, observer);
    EXPECT_EQ(hit.prim_id, expected.prim_id) << "ray " << i;
    EXPECT_EQ(hit.t, expected.t) << "ray " << i;
  }
}

template <class Builder>
void expect_progress_interrupts() {
  BuildOptions options;
  options.progress = [](std::string_view, double) { return false; };
  const auto built = Builder::build(soup(20000, 0.1f), options);
  ASSERT_FALSE(built.ok());
  EXPECT_EQ(built.message(), kInterrupted);
}

// Whether options that `change` has made are an error.
template <class Builder, class Change>
bool refuses(const Change& change) {
  BuildOptions options;
  change(options);
  return !Builder::build(TriangleMesh{}, options).ok();
}

// No triangles, and none that a ray can hit.
inline std::vector<TriangleMesh> empty_meshes() { return {TriangleMesh{}, mesh_of({Triangle{}, Triangle{}})}; }

}  // namespace accel::test
