// PLY, the Stanford polygon format: ASCII, binary little-endian and binary big-endian.
//
// Read are the properties x, y and z of the element `vertex` and the list vertex_indices (or vertex_index) of the element
// `face`, all of any type; every other property and element is passed over. `tristrips` are not supported.
//
// Nothing may follow the last element, but for white space in ASCII, where each item has a line of its own: counts that do not
// fit the body are errors, whichever of the two is wrong.
//
// The longest run of triangles at the start of a binary file's faces is read in parallel at the speed of memory, since such
// faces have a fixed size; what follows it, and ASCII, is read face by face.
#pragma once

#include <span>
#include <string>

#include "libaccel/io/load_mesh.h"

namespace accel {

// `name` is the file's, for messages.
Result<TriangleMesh> parse_ply(std::span<const std::byte> bytes, const std::string& name, const LoadOptions& options = {});

}  // namespace accel
