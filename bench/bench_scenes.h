// The scenes that the benchmarks run on, and their own command line.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "libaccel/geometry/scene_data.h"
#include "libaccel/rays/ray_kind.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/any_accel.h"

namespace accel::bench {

struct Options {
  std::vector<std::string> scenes;  // files, or builtin:NAME[:size]
  std::uint64_t rays = 250'000;     // of each kind, about
  int threads = 1;
};

// Takes --scenes=A,B,..., --rays=N and --threads=N out of the arguments. Without --scenes: every scene file in the folder that
// the environment variable ACCEL_SCENES_DIR names, or else the built-in scenes.
Result<Options> parse_options(int& argc, char** argv);

struct Scene {
  std::string name;
  SceneData data;
};

Result<Scene> load(const std::string& spec);

// The scene as the method traces it: its instances, where there are any and the method keeps them apart, or one mesh.
Result<AnyAccel> build(const Scene& scene, const MethodInfo& method, const BuildOptions& options = {});

// About `count` rays of a kind. Primary rays see the scene through its camera; the other image kinds start from their hits.
Result<RaySet> make_rays(const Scene& scene, RayKind kind, std::uint64_t count);

}  // namespace accel::bench
