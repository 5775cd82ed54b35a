// Triangles out of scene files: OBJ, PLY and glTF (.gltf and .glb), each of them also packed with zstd, as in NAME.ply.zst.
//
// The format is told by the file's name, in any case of letters. Polygons are triangulated (geometry/triangulate_polygon.h);
// the prim_id of a triangle is its number in file order after that: a polygon of n corners takes n - 2 consecutive numbers, a
// face with fewer than three corners none. Positions may hold anything, NaN and infinities included: builders skip and report
// the triangles that use them. Duplicate and zero-area triangles are kept. Coordinates that a file holds in double precision or
// as integers are rounded to float.
//
// Errors name the file and the line, the element or the byte. Nothing is allocated on a file's word alone: the counts that it
// states are compared with its size first.
#pragma once

#include <cstdint>
#include <filesystem>

#include "libaccel/core/progress.h"
#include "libaccel/geometry/scene_data.h"

namespace accel {

struct LoadOptions {
  Progress progress;
  std::uint64_t* skipped_faces = nullptr;  // faces with fewer than three corners are counted here, if somewhere
};

// Whether the name ends like a scene file's: .obj, .ply, .gltf or .glb, with or without .zst.
bool is_mesh_file_name(const std::filesystem::path& path);

// All that a file holds: glTF (io/gltf.h) may have cameras, a light and instances. What stands beside it is not read: see
// io/load_scene.h.
Result<SceneData> load_file(const std::filesystem::path& path, const LoadOptions& options = {});

// Its triangles as one mesh.
Result<TriangleMesh> load_mesh(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace accel
