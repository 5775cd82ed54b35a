// Wavefront OBJ: the `v` and `f` lines of a file, through tinyobjloader's callbacks.
//
// Everything else (normals, texture coordinates, groups, materials and their libraries, lines, points, curves) is passed over,
// and so are a vertex's w and colours. Vertex numbers count from 1, negative ones back from the last vertex before the face; a
// face may name vertices that follow it. Lines end in LF, CR LF or CR; a comment may follow a face.
//
// Deviations from tinyobjloader 2.0: its triangulation is not used (it splits quads along the shorter diagonal, which lies
// outside a concave one, and compares areas with a fixed epsilon, which loses small polygons); and what it reads as 0 (words,
// numbers that are missing or too large) is an error, except nan and inf.
#pragma once

#include <span>
#include <string>

#include "libaccel/io/load_mesh.h"

namespace accel {

// `name` is the file's, for messages.
Result<TriangleMesh> parse_obj(std::span<const std::byte> bytes, const std::string& name, const LoadOptions& options = {});

}  // namespace accel
