// What a structure file holds: metadata, the mesh or the instances and their facts, and the arrays of one structure.
//
// A scene of instances has its meshes one behind the other in the sections of the mesh, and two more: how much of them each
// mesh is ("scene.meshes"), and which mesh is placed where ("scene.instances").
// A structure's sections are its arrays, by the names that it gives them (structure/arrays.h), and its words: "bvh2.nodes",
// "bvh2.words". So there is nothing to add here for a new structure.
// Readers validate all that they read: what they return is as safe to traverse as what a builder made. The mesh is read only
// when it is asked for: facts and structures are read without touching its pages, so that a program which only traces never
// does.
//
// Errors are the container's (io/accel_file.h) and those of validate() of the structure. read() and save_accel() are the whole
// of it, and return an error where memory ends too; their parts, read_sections() and write_sections(), throw std::bad_alloc
// then.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "libaccel/core/camera_description.h"
#include "libaccel/core/light_description.h"
#include "libaccel/core/out_of_memory.h"
#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/geometry/triangle_mesh.h"
#include "libaccel/io/accel_file.h"
#include "libaccel/structure/arrays.h"

namespace accel {

// Where the structure came from and what its builder said about it. Kept as JSON in the section "metadata".
struct AccelMetadata {
  std::string structure;                       // Structure::kName
  std::string builder;                         // Builder::kName
  std::string scene;                           // as the user named it
  std::map<std::string, std::string> options;  // of the build, by name
  std::map<std::string, double> statistics;    // triangles, sah_cost, …
  std::vector<CameraDescription> cameras;
  std::optional<LightDescription> light;
};

// A statistic that counts something; 0 where there is none, or one that cannot be.
std::uint64_t counted(const AccelMetadata& metadata, const std::string& statistic);

// Moves an array out of the file into `out`.
template <class T>
Status take_section(const AccelFile& file, std::string_view name, Buffer<T>& out) {
  Result<Buffer<T>> values = file.array<T>(name);
  if (!values) return values.error();
  out = *std::move(values);
  return Done{};
}

// An error of validate() as an error of the file.
inline Status in_file(const AccelFile& file, const Status& status) {
  return status ? status : Status(file.error({}, "holds a damaged structure: " + status.message()));
}

void write_sections(AccelFileWriter& writer, const AccelMetadata& metadata);
// The mesh or the instances, and their facts.
void write_sections(AccelFileWriter& writer, const TriangleMesh& mesh);
void write_sections(AccelFileWriter& writer, const InstancedMeshes& scene);

Status read_sections(const AccelFile& file, AccelMetadata& metadata);
Status read_sections(const AccelFile& file, TriangleMesh& mesh);
Status read_sections(const AccelFile& file, MeshFacts& facts);
Status read_sections(const AccelFile& file, InstancedMeshes& scene);

// Whether the file's scene is one of instances.
bool has_instances(const AccelFile& file);

// The number of triangles of the file's mesh or of all its instances, without touching a vertex.
std::uint64_t triangle_count(const AccelFile& file);

template <StructureOfArrays Structure>
void write_sections(AccelFileWriter& writer, const Structure& structure) {
  const std::string prefix = std::string(Structure::kName) + ".";
  if constexpr (requires { typename Structure::Words; })
    writer.add_value<typename Structure::Words>(prefix + "words", structure);
  Structure::for_each_array(structure,
                            [&](std::string_view name, const auto& array) { writer.add(prefix + std::string(name), array); });
}

template <StructureOfArrays Structure>
Status read_sections(const AccelFile& file, Structure& structure) {
  const std::string prefix = std::string(Structure::kName) + ".";
  if constexpr (requires { typename Structure::Words; }) {
    const auto words = file.value<typename Structure::Words>(prefix + "words");
    if (!words) return words.error();
    static_cast<typename Structure::Words&>(structure) = *words;
  }
  Status status = Done{};
  Structure::for_each_array(structure, [&](std::string_view name, auto& array) {
    if (status) status = take_section(file, prefix + std::string(name), array);
  });
  return status ? in_file(file, validate(structure, triangle_count(file))) : status;
}

// Any of them: read<Bvh2>(file).
template <class T>
Result<T> read(const AccelFile& file) try {
  T value;
  if (Status status = read_sections(file, value); !status) return status.error();
  return value;
} catch (const std::bad_alloc&) {
  return out_of_memory("reading a structure file");
}

// Writes a whole structure file; metadata.structure is the structure's kind, whatever was there. The scene is a mesh that
// validate() accepts (else an error) or InstancedMeshes, whichever the structure was built over.
template <class Scene, class Structure>
Status save_accel(const std::filesystem::path& path, const AccelMetadata& metadata, const Scene& scene,
                  const Structure& structure) try {
  if constexpr (std::is_same_v<Scene, TriangleMesh>)
    if (const Status status = validate(scene); !status) return status;
  AccelFileWriter writer;
  AccelMetadata named = metadata;
  named.structure = Structure::kName;
  write_sections(writer, named);
  write_sections(writer, scene);
  write_sections(writer, structure);
  return writer.write(path);
} catch (const std::bad_alloc&) {
  return out_of_memory("writing a structure file");
}

}  // namespace accel
