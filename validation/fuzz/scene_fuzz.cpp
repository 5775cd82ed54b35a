// What stands beside scenes: the JSON form, and the table where the text begins with #. What is accepted can be used.
#include <cmath>

#include "libaccel/io/scene_description.h"
#include "validation/fuzz/fuzz_input.h"

namespace {

using namespace accel;

void check(const Result<SceneDescription>& scene) {
  if (!scene) return fuzz::require(!scene.message().empty(), "an error without a message");
  for (const CameraDescription& camera : scene->cameras)
    fuzz::require(validate(camera).ok(), "a camera that cannot be used: " + camera.name);
  if (!scene->instances) return;
  for (const InstanceDescription& instance : *scene->instances)
    fuzz::require(inverse(instance.transform).ok(), "an instance whose transform has no inverse");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = fuzz::text_of({data, size});
  check(text.starts_with('#') ? parse_scene_table(text, "scenes.tsv", "a.ply") : parse_scene_json(text, "a.json"));
  return 0;
}
