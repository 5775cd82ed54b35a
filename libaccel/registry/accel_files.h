// Structure files with whatever structure they hold: io/structure_sections.h, with the types erased.
//
//   accel::save_accel("scene.accel", *scene, *mesh);
//   const auto again = accel::load_accel("scene.accel");
//
// Errors are those of io/structure_sections.h and of AnyAccel::bind().
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "libaccel/io/structure_sections.h"
#include "libaccel/registry/any_accel.h"

namespace accel {

// A structure as a file holds it.
struct StoredStructure {
  AnyStructure structure;
  BuildReport report;   // what was built, not how the build went
  std::string builder;  // who made it
};

// `metadata` is the file's.
Result<StoredStructure> read_structure(const AccelFile& file, const AccelMetadata& metadata);

// Writes the handle's structure with the scene that it was built over, as one mesh where its method does not keep instances
// apart. What the handle knows is added to the metadata: structure, builder, and the statistics of the build. An
// error for a scene that cannot be the one: readers would refuse the file.
Status save_accel(const std::filesystem::path& path, const AnyAccel& accel, const TriangleMesh& scene,
                  AccelMetadata metadata = {});
Status save_accel(const std::filesystem::path& path, const AnyAccel& accel, const InstancedMeshes& scene,
                  AccelMetadata metadata = {});

// The structure of a file, mapped and bound to a method; "best" is that of who built it, or of its kind. Whoever wants the
// scene or the cameras too opens an AccelFile and reads them.
Result<AnyAccel> load_accel(const std::filesystem::path& path, std::string_view method = "best");

}  // namespace accel
