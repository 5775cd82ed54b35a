// Packed scenes, through the file's name as users load them. Seeds are packed without compression, so that changes of the
// packed bytes are changes of the mesh, or of zstd's frames.
#include "libaccel/io/load_mesh.h"
#include "validation/fuzz/mesh_checks.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const accel::fuzz::InputFile file(".ply.zst");
  accel::fuzz::check_mesh(accel::load_mesh(file.holding({data, size})));
  return 0;
}
