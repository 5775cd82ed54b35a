// Wavefront OBJ: the `v` and `f` lines of a file, through tinyobjloader's callbacks.
//
// Everything else (normals, texture coordinates, groups, materials and their libraries, lines, points, curves) is passed over,
// and so are a vertex's w and colours. Vertex numbers count from 1, negative ones back from the last vertex before the face; a
// face may name vertices that follow it. Lines end in LF, CR LF or CR; a comment may follow a face. A backslash at the end of
// a line that is no comment continues it, and separates words. A byte-order mark of UTF-8 may come first.
//
// Deviations from tinyobjloader 2.0: its triangulation is not used (it splits quads along the shorter diagonal, which lies
// outside a concave one, and compares areas with a fixed epsilon, which loses small polygons); coordinates are rounded once,
// from their digits; and words that are no number as a whole, of which it reads the beginning or 0, are errors.
#pragma once

#include <span>
#include <string>

#include "libaccel/io/load_mesh.h"

namespace accel {

// `name` is the file's, for messages.
Result<TriangleMesh> parse_obj(std::span<const std::byte> bytes, const std::string& name, const LoadOptions& options = {});

}  // namespace accel
