// apps/common/image.h in builds without OpenImageIO.
#include "apps/common/image.h"

namespace accel::apps {

namespace {

Failure no_library() {
  return {ExitStatus::unavailable,
          "this program was built without OpenImageIO and writes no pictures; install libopenimageio-dev and build with "
          "-DACCEL_WITH_OIIO=ON"};
}

}  // namespace

bool images_available() { return false; }
std::string image_library_version() { return "not built in"; }
Finished check_image_name(const std::filesystem::path&, std::string_view flag) {
  return Failure(ExitStatus::unavailable, std::string(flag) + ": " + no_library().message);
}
Finished write_shaded(const std::filesystem::path&, const ShadedPicture&) { return no_library(); }
Finished write_heat(const std::filesystem::path&, const HeatPicture&, const std::string&) { return no_library(); }
Finished write_classes(const std::filesystem::path&, const HeatPicture&, const ClassPicture&, const std::string&) {
  return no_library();
}
Outcome<std::string> heat_png(const HeatPicture&, double) { return no_library(); }
Outcome<std::string> class_png(const ClassPicture&) { return no_library(); }

}  // namespace accel::apps
