#include "apps/common/image.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "apps/common/program_files.h"
#include "apps/images/image_functions.h"

namespace accel::apps {

namespace {

constexpr std::array<const char*, 5> kEndings = {"png", "exr", "jpg", "jpeg", "tif"};

Outcome<const ImageFunctions*> load_images() {
  const auto failed = [](const std::string& why) {
    return Failure(ExitStatus::unavailable, "cannot load what writes pictures: " + why);
  };
  const std::filesystem::path path = find_program_file(ACCEL_IMAGES_FOLDER, ACCEL_IMAGES_FILE);
  if (path.empty()) return failed(ACCEL_IMAGES_FILE " is neither next to the program nor where it was installed");
  void* const module = dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
  void* const symbol = module == nullptr ? nullptr : dlsym(module, kGetImageFunctions);
  if (symbol == nullptr) return failed(dlerror());
  return reinterpret_cast<GetImageFunctions*>(symbol)();
}

// Loaded when it is first needed, and kept.
const Outcome<const ImageFunctions*>& images() {
  static const Outcome<const ImageFunctions*> loaded = load_images();
  return loaded;
}

}  // namespace

bool images_available() { return true; }

std::string image_library_version() { return "OpenImageIO " ACCEL_OIIO_VERSION; }

std::string image_ending(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  if (!ending.empty()) ending.erase(0, 1);
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending;
}

Finished check_image_name(const std::filesystem::path& path, std::string_view flag) {
  const std::string ending = image_ending(path);
  if (std::find(kEndings.begin(), kEndings.end(), ending) == kEndings.end())
    return Failure(ExitStatus::usage, std::string(flag) + ": '" + path.string() + "' should end in .png, .exr, .jpg or .tif");
  if (!images()) return images().failure();
  return Done{};
}

Finished write_shaded(const std::filesystem::path& path, const ShadedPicture& picture) {
  return images() ? (*images())->shaded(path, picture) : Finished(images().failure());
}

Finished write_heat(const std::filesystem::path& path, const HeatPicture& picture, const std::string& channel) {
  return images() ? (*images())->heat(path, picture, channel) : Finished(images().failure());
}

Finished write_classes(const std::filesystem::path& path, const HeatPicture& heat, const ClassPicture& classes,
                       const std::string& channel) {
  return images() ? (*images())->classes(path, heat, classes, channel) : Finished(images().failure());
}

Outcome<std::string> heat_png(const HeatPicture& picture, double top) {
  return images() ? (*images())->heat_png(picture, top) : Outcome<std::string>(images().failure());
}

Outcome<std::string> class_png(const ClassPicture& picture) {
  return images() ? (*images())->class_png(picture) : Outcome<std::string>(images().failure());
}

}  // namespace accel::apps
