// The meshes of a glTF file (glTF 2.0, section 3.7), each read once, when it is first placed.
//
// A mesh's triangles are those of its primitives, one after the other. Its vertices are those that its triangles name, in the
// order in which they do: many meshes may use a part each of the same positions.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "libaccel/geometry/triangle_mesh.h"
#include "libaccel/io/gltf_buffers.h"
#include "libaccel/io/json_cursor.h"
#include "libaccel/io/progress_ticker.h"

namespace accel {

// What an index names in one of the document's lists; and an extension of an object, if it has that.
JsonCursor gltf_entry(const JsonCursor& document, const char* list, const JsonCursor& index);
std::optional<JsonCursor> gltf_extension(const JsonCursor& holder, const char* name);

class GltfMeshes {
 public:
  GltfMeshes(const JsonCursor& document, GltfBuffers& buffers, ProgressTicker& ticker)
      : document_(document), buffers_(buffers), ticker_(ticker) {}

  // The number, among those that have been read, of the mesh that an index names.
  std::uint32_t number_of(const JsonCursor& index);
  std::vector<TriangleMesh> take() { return std::move(meshes_); }

  // Tells progress; a FormatError, kInterrupted, where the caller asked to stop.
  void tick();

 private:
  // The positions of an accessor.
  struct Positions {
    std::vector<float> points;  // three numbers each
    std::vector<std::uint32_t> vertex_of_point, known;

    std::uint32_t vertex(std::uint32_t point, std::vector<Vec3>& vertices);
    void forget_vertices();
  };

  TriangleMesh read(const JsonCursor& mesh);
  Positions& positions_of(const JsonCursor& primitive, const JsonCursor& index);
  std::vector<std::uint32_t> corners_of(const JsonCursor& primitive, std::uint64_t mode, std::uint64_t points);

  JsonCursor document_;
  GltfBuffers& buffers_;
  ProgressTicker& ticker_;
  std::map<std::uint64_t, Positions> positions_;  // by accessor
  std::vector<TriangleMesh> meshes_;
  std::map<std::uint64_t, std::uint32_t> numbers_;  // by number in the file
};

}  // namespace accel
