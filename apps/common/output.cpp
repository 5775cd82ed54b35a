#include "apps/common/output.h"

#include <filesystem>
#include <map>

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

// What the files are that a run reads.
std::map<std::filesystem::path, std::string> roles_of(const InputFiles& inputs) {
  std::map<std::filesystem::path, std::string> roles;
  for (const std::string& path : inputs.others) roles.emplace(identity(path), "is read");
  if (inputs.scene.empty() || inputs.scene.starts_with("builtin:")) return roles;
  roles.emplace(identity(inputs.scene), "is the scene");
  if (inputs.scene.ends_with(".accel")) return roles;  // it holds its own description
  for (const std::filesystem::path& name : scene_description_names(inputs.scene))
    roles.emplace(identity(name.string()), "is where cameras and light of '" + inputs.scene + "' are looked for");
  return roles;
}

}  // namespace

Finished check_outputs(std::initializer_list<OutputFile> files, const InputFiles& inputs) {
  std::map<std::filesystem::path, std::string_view> flag_of;
  const std::map<std::filesystem::path, std::string> role_of = roles_of(inputs);
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

Finished PendingOutputs::add(const std::string& target, const std::function<Finished(const std::string& path)>& write) {
  if (target.empty()) return Done{};
  auto file = AtomicPath::create(target);
  if (!file) return file.error();
  if (auto done = write(file->path().string()); !done) return done;
  files_.push_back(*std::move(file));
  return Done{};
}

Finished PendingOutputs::publish() {
  for (AtomicPath& file : files_)
    if (const Status done = file.commit(); !done) return done.error();
  return Done{};
}

}  // namespace accel::apps
