// Scenes of the catalogue's geometry cases (catalogue.h), in two sizes: hundreds of triangles, so that brute force over all of
// them is quick, and up to a million. Seeded.
#pragma once

#include <cstdint>
#include <vector>

#include "validation/stress/stress_scenes.h"

namespace accel::validation {

enum class SceneSize : std::uint8_t { small, large };

using SceneMaker = std::vector<StressScene> (*)(SceneSize, std::uint64_t seed);

std::vector<StressScene> empty_scenes(SceneSize, std::uint64_t);
std::vector<StressScene> usual_scenes(SceneSize, std::uint64_t);           // what most kinds of rays are traced through
std::vector<StressScene> assorted_scenes(SceneSize, std::uint64_t);        // stress_scenes()
std::vector<StressScene> lattices(SceneSize, std::uint64_t);               // cell_stress_scenes()
std::vector<StressScene> scaled_scenes(SceneSize, std::uint64_t);          // by 2^-40 to 2^40
std::vector<StressScene> translated_scenes(SceneSize, std::uint64_t);      // closed meshes at 0, 1, 1e2, 1e4
std::vector<StressScene> far_translated_scenes(SceneSize, std::uint64_t);  // and at 1e6
std::vector<StressScene> sliver_scenes(SceneSize, std::uint64_t);          // three vertices nearly on a line: aspect 1e7
std::vector<StressScene> needle_scenes(SceneSize, std::uint64_t);          // two vertices 1e-7 apart
std::vector<StressScene> zero_area_scenes(SceneSize, std::uint64_t);       // points and segments, and nothing else
std::vector<StressScene> partly_zero_area_scenes(SceneSize, std::uint64_t);
std::vector<StressScene> one_many_times(SceneSize, std::uint64_t);    // the first triangle is what must be hit
std::vector<StressScene> few_many_times(SceneSize, std::uint64_t);    // the first hundred are
std::vector<StressScene> stacks_of_planes(SceneSize, std::uint64_t);  // coplanar, and one float apart
std::vector<StressScene> t_junctions(SceneSize, std::uint64_t);
std::vector<StressScene> flat_scenes(SceneSize, std::uint64_t);       // in each axis
std::vector<StressScene> thin_boxes(SceneSize, std::uint64_t);        // boxes of no or one float's extent in one axis
std::vector<StressScene> one_centroid(SceneSize, std::uint64_t);      // all boxes around one point
std::vector<StressScene> diagonal_slivers(SceneSize, std::uint64_t);  // which spatial splits cut again and again
std::vector<StressScene> deep_trees(SceneSize, std::uint64_t);        // deeper than 32, and than 64 where the builder follows
std::vector<StressScene> world_among_dust(SceneSize, std::uint64_t);
std::vector<StressScene> broken_coordinates(SceneSize, std::uint64_t);  // NaN, infinite, beyond the range: dropped
std::vector<StressScene> broken_indices(SceneSize, std::uint64_t);      // beyond the vertices: no build

// What the duplicates of `few_many_times` and `one_many_times` are copies of: the first triangles of the mesh, each once.
TriangleMesh without_copies(const TriangleMesh& mesh);

}  // namespace accel::validation
