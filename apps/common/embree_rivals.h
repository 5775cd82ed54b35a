// Embree as what methods are timed against: the modes that --embree names, and the one that ratios refer to.
#pragma once

#include <string>
#include <vector>

#include "apps/common/embree_modes.h"
#include "apps/common/embree_scenes.h"
#include "apps/common/measure.h"
#include "apps/common/trace_options.h"
#include "apps/common/trace_report.h"
#include "libaccel/rays/ray_sets.h"

namespace accel::apps {

struct EmbreeRival {
  const EmbreeTimed* timed;
  const validation::EmbreeWitness* scene;
  Engine engine;  // must not outlive the scenes
};

// Embree in one of its ways; the engine must not outlive the scene.
Engine engine_of(const EmbreeTimed& timed, const validation::EmbreeWitness& scene, int threads);

// Builds the scenes that are timed, of instances or of one mesh: none where neither the check nor --embree asks for Embree.
// Modes that this Embree does not have for the scene are an error if named, and skipped with "all".
Outcome<std::vector<EmbreeRival>> make_rivals(EmbreeScenes& scenes, const TraceSettings& settings, Truth truth,
                                              std::vector<Skip>& skipped);

// "Embree", "Embree/stream".
std::string row_name(const EmbreeTimed& timed);

// "Embree (medium, fast)".
std::string structure_name(const validation::EmbreeWitness& scene);

// The rays along a Z-curve of their pixels, so that any 1024 of one sample a pixel are a tile of 32 x 32 or nearly so; empty
// for rays without pixels, which stay as they are.
Buffer<Ray> by_tiles(const RaySet& set, std::uint32_t width);

}  // namespace accel::apps
