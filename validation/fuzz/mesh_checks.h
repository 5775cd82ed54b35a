// What must hold for every mesh that a reader returns, whatever the file was.
#pragma once

#include "libaccel/geometry/triangle_mesh.h"
#include "validation/fuzz/fuzz_input.h"

namespace accel::fuzz {

// A mesh that validate() accepts, or an error that says something.
inline void check_mesh(const Result<TriangleMesh>& mesh) {
  if (!mesh) return require(!mesh.message().empty(), "an error without a message");
  const Status valid = validate(*mesh);
  require(valid.ok(), valid ? "" : "the reader returned a mesh that is not valid: " + valid.message());
}

}  // namespace accel::fuzz
