#include "libaccel/registry/accel_files.h"

#include <algorithm>
#include <new>
#include <utility>

#include "libaccel/core/out_of_memory.h"
#include "libaccel/registry/structures.h"

namespace accel {
namespace {

// The file's structure as whichever of the registry's types it says it is.
Result<AnyStructure> structure_of(const AccelFile& file, const std::string& kind) {
  Result<AnyStructure> result =
      file.error("metadata", "names a structure of unknown kind '" + kind + "'; it was written by another version");
  Structures::for_each([&](auto tag) {
    using Structure = typename decltype(tag)::type;
    if (kind != Structure::kName) return;
    Result<Structure> structure = read<Structure>(file);
    result = structure ? Result<AnyStructure>(AnyStructure(*std::move(structure))) : Result<AnyStructure>(structure.error());
  });
  return result;
}

template <class Scene>
Status save(const std::filesystem::path& path, const AnyAccel& accel, const Scene& scene, AccelMetadata metadata) try {
  const BuildReport& report = accel.report();
  metadata.builder = accel.method().builder;
  metadata.statistics["triangles"] = static_cast<double>(report.triangles);
  metadata.statistics["references"] = static_cast<double>(report.references);
  metadata.statistics["skipped_zero_area"] = static_cast<double>(report.skipped.zero_area);
  metadata.statistics["skipped_out_of_range"] = static_cast<double>(report.skipped.out_of_range);
  // There is a status: the structure of a method is in the list.
  return *visit_structure(accel.structure(), [&](const auto& s) {
    if (const Status valid = validate(s, scene.size()); !valid)
      return Status(Error{path.string() + ": is not written, for the structure is not of this scene: " + valid.message()});
    return save_accel(path, metadata, scene, s);
  });
} catch (const std::bad_alloc&) {
  return out_of_memory("writing a structure file");
}

}  // namespace

Result<StoredStructure> read_structure(const AccelFile& file, const AccelMetadata& metadata) try {
  auto structure = structure_of(file, metadata.structure);
  if (!structure) return structure.error();
  BuildReport report;
  report.triangles = counted(metadata, "triangles");
  report.references = counted(metadata, "references");
  report.skipped.zero_area = counted(metadata, "skipped_zero_area");
  report.skipped.out_of_range = counted(metadata, "skipped_out_of_range");
  return StoredStructure{*std::move(structure), std::move(report), metadata.builder};
} catch (const std::bad_alloc&) {
  return out_of_memory("reading a structure file");
}

Status save_accel(const std::filesystem::path& path, const AnyAccel& accel, const TriangleMesh& scene, AccelMetadata metadata) {
  return save(path, accel, scene, std::move(metadata));
}

Status save_accel(const std::filesystem::path& path, const AnyAccel& accel, const InstancedMeshes& scene,
                  AccelMetadata metadata) {
  if (accel.method().instances) return save(path, accel, scene, std::move(metadata));
  const auto mesh = scene.flattened();
  return mesh ? save(path, accel, *mesh, std::move(metadata)) : mesh.error();
}

Result<AnyAccel> load_accel(const std::filesystem::path& path, std::string_view method) try {
  const auto file = AccelFile::open(path);
  if (!file) return file.error();
  const auto metadata = read<AccelMetadata>(*file);
  if (!metadata) return metadata.error();
  auto stored = read_structure(*file, *metadata);
  if (!stored) return stored.error();
  const std::string best = best_method({.builder = stored->builder});
  const auto is_of_builder = [&](const MethodInfo& m) { return m.name == best && m.builder == stored->builder; };
  if (method == "best" && std::any_of(methods().begin(), methods().end(), is_of_builder)) method = best;
  return AnyAccel::bind(std::move(stored->structure), method, std::move(stored->report));
} catch (const std::bad_alloc&) {
  return out_of_memory("reading a structure file");
}

}  // namespace accel
