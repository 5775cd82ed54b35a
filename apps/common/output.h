// Text files, written whole or not at all.
#pragma once

#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "apps/common/failure.h"
#include "libaccel/io/atomic_file.h"

namespace accel::apps {

Finished write_text(const std::string& path, std::string_view text);

struct OutputFile {
  std::string_view flag, path;  // the option that names it; empty: none, "-": standard output
};

// Files that a run reads: those of a scene, with what may stand beside it, and others.
struct InputFiles {
  std::string scene;
  std::vector<std::string> others = {};
};

// Whether files can be made where the paths say, and each is another one and none that is read, found out before work is done
// that would be lost. Two outputs to one file are a usage error, and so is one in place of an input, or where the scene's
// description is looked for.
Finished check_outputs(std::initializer_list<OutputFile> files, const InputFiles& inputs);

// Files of a run, which appear when all of it is done, and not at all if it fails.
class PendingOutputs {
 public:
  // Writes one by write(path); none where `target` is empty.
  Finished add(const std::string& target, const std::function<Finished(const std::string& path)>& write);
  // Puts all in their places.
  Finished publish();

 private:
  std::vector<AtomicPath> files_;
};

}  // namespace accel::apps
