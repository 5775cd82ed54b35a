// What a structure file holds: metadata, the mesh, and the arrays of one structure.
//
// A structure is kept by a pair of functions, write_sections() and read_sections(); adding one means adding its pair here.
// Readers validate all that they read: what they return is as safe to traverse as what a builder made. The mesh is read only
// when it is asked for; tracing without checks never touches its pages.
//
// Errors are the container's (io/accel_file.h) and those of validate() of the structure.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libaccel/core/camera_description.h"
#include "libaccel/core/light_description.h"
#include "libaccel/io/accel_file.h"
#include "libaccel/structure/bvh2.h"
#include "libaccel/structure/triangle_list.h"

namespace accel {

// Where the structure came from and what its builder said about it. Kept as JSON in the section "metadata".
struct AccelMetadata {
  std::string structure;                       // Structure::kName
  std::string builder;                         // Builder::kName
  std::string scene;                           // as the user named it
  std::map<std::string, std::string> options;  // of the build, by name
  std::map<std::string, double> statistics;    // build_seconds, sah_cost, …
  std::vector<CameraDescription> cameras;
  std::optional<LightDescription> light;
};

void write_sections(AccelFileWriter& writer, const AccelMetadata& metadata);
void write_sections(AccelFileWriter& writer, const TriangleMesh& mesh);
void write_sections(AccelFileWriter& writer, const Bvh2& bvh);
void write_sections(AccelFileWriter& writer, const TriangleList& list);

Status read_sections(const AccelFile& file, AccelMetadata& metadata);
Status read_sections(const AccelFile& file, TriangleMesh& mesh);
Status read_sections(const AccelFile& file, Bvh2& bvh);
Status read_sections(const AccelFile& file, TriangleList& list);

// Any of them: read<Bvh2>(file).
template <class T>
Result<T> read(const AccelFile& file) {
  T value;
  if (Status status = read_sections(file, value); !status) return status.error();
  return value;
}

// The number of triangles of the file's mesh, without touching it.
std::uint64_t triangle_count(const AccelFile& file);

// Writes a whole structure file.
template <class Structure>
Status save_accel(const std::filesystem::path& path, const AccelMetadata& metadata, const TriangleMesh& mesh,
                  const Structure& structure) {
  AccelFileWriter writer;
  write_sections(writer, metadata);
  write_sections(writer, mesh);
  write_sections(writer, structure);
  return writer.write(path);
}

}  // namespace accel
