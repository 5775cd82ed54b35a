#include "apps/common/output.h"

#include <filesystem>
#include <map>

#include "libaccel/io/atomic_file.h"
#include "libaccel/io/scene_description.h"

namespace accel::apps {

Finished write_text(const std::string& path, std::string_view text) {
  if (const Status written = write_file(path, text); !written) return written.error();
  return Done{};
}

namespace {

// The same for all names of a file.
std::filesystem::path identity(std::string_view path) {
  std::error_code ignored;
  return path == "-" ? std::filesystem::path(path)
                     : std::filesystem::weakly_canonical(std::filesystem::absolute(path, ignored), ignored);
}

}  // namespace

Finished check_outputs(std::initializer_list<OutputFile> files, const InputFiles& inputs) {
  std::map<std::filesystem::path, std::string_view> flag_of;
  std::map<std::filesystem::path, std::string> role_of;
  if (!inputs.scene.empty() && !inputs.scene.starts_with("builtin:")) {
    role_of.emplace(identity(inputs.scene), "is the scene");
    const bool has_description = !inputs.scene.ends_with(".accel");  // such a file holds its own
    for (const std::filesystem::path& name :
         has_description ? scene_description_names(inputs.scene) : std::vector<std::filesystem::path>())
      role_of.emplace(identity(name.string()), "is where cameras and light of '" + inputs.scene + "' are looked for");
  }
  for (const std::string& path : inputs.others) role_of.emplace(identity(path), "is read");
  for (const auto& [flag, path] : files) {
    if (path.empty()) continue;
    if (const auto role = role_of.find(identity(path)); path != "-" && role != role_of.end())
      return Failure(ExitStatus::usage,
                     std::string(flag) + ": '" + std::string(path) + "' " + role->second + "; give another name");
    const auto [same, is_new] = flag_of.emplace(identity(path), flag);
    if (!is_new)
      return Failure(ExitStatus::usage, std::string(same->second) + ", " + std::string(flag) + ": only one of them can be " +
                                            (path == "-" ? "standard output" : "written to '" + std::string(path) + "'"));
    if (path == "-") continue;
    if (const auto probe = AtomicPath::create(path); !probe) return probe.error();
  }
  return Done{};
}

}  // namespace accel::apps
