// PLY files, ASCII and binary in both byte orders: any bytes are a valid mesh or an error.
#include "libaccel/io/ply.h"
#include "validation/fuzz/mesh_checks.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  accel::fuzz::check_mesh(accel::parse_ply(accel::fuzz::bytes_of({data, size}), "fuzz.ply"));
  return 0;
}
