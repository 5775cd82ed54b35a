// OBJ files: any text is a valid mesh or an error.
#include "libaccel/io/obj.h"
#include "validation/fuzz/mesh_checks.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  accel::fuzz::check_mesh(accel::parse_obj(accel::fuzz::bytes_of({data, size}), "fuzz.obj"));
  return 0;
}
