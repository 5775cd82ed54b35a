// What a program works on: a scene from a file or a generator, or a structure file with the scene inside.
#pragma once

#include <optional>
#include <string>

#include "apps/common/failure.h"
#include "libaccel/build/builder.h"
#include "libaccel/core/progress.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/geometry/scene_data.h"
#include "libaccel/registry/accel_files.h"

namespace accel::apps {

struct Scene {
  std::string name;                       // as the user gave it
  std::string title;                      // for headings: the file's name without its folder
  SceneData data;                         // without a mesh, where none is needed
  MeshFacts facts;                        // of the mesh, in any case
  std::optional<StoredStructure> stored;  // of a .accel file
  BuildOptions stored_costs;              // by which it was built; of the options, these alone
  std::uint64_t skipped_faces = 0;        // of a scene file: those with fewer than three corners
  double load_seconds = 0;

  TriangleSource triangles() const { return data.triangles(); }
};

// Whether a program is going to look at triangles. If not, those of a structure file are not even read.
enum class MeshUse : bool { none, reads };

// Opens what a SCENE argument names. A built-in scene's unknown name is a usage error, everything else an input error.
Outcome<Scene> open_scene(const std::string& argument, std::uint64_t seed, const Progress& progress,
                          MeshUse use = MeshUse::reads);

// The camera that --camera chooses: ten numbers, the name or the number of one of the scene's, or by default its first or the
// one that its box suggests. Unknown names are usage errors.
Outcome<CameraDescription> choose_camera(const Scene& scene, const std::string& argument);

// The scene's own light, or the one that its box suggests.
LightDescription choose_light(const Scene& scene, const CameraDescription& camera);

}  // namespace accel::apps
