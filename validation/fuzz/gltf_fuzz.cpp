// glTF, as JSON and as .glb: any bytes are a scene that can be used or an error. Buffers in files beside it are not there.
#include "libaccel/io/gltf.h"

#include "libaccel/io/scene_description.h"
#include "validation/fuzz/mesh_checks.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace accel;
  const Result<SceneData> scene = parse_gltf(fuzz::bytes_of({data, size}), "no-such-folder/fuzz.gltf");
  if (!scene) return fuzz::require(!scene.message().empty(), "an error without a message"), 0;
  for (const CameraDescription& camera : scene->cameras)
    fuzz::require(validate(camera).ok(), "a camera that cannot be used: " + camera.name);
  if (scene->light) fuzz::require(in_range(scene->light->center), "a light that is nowhere");
  if (scene->instances) fuzz::check_mesh(scene->one_mesh());
  fuzz::check_mesh(scene->mesh);
  return 0;
}
