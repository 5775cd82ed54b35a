#include "apps/common/output.h"

#include "libaccel/io/atomic_file.h"

namespace accel::apps {

Finished write_text(const std::string& path, std::string_view text) {
  if (const Status written = write_file(path, text); !written) return written.error();
  return Done{};
}

Finished check_writable(std::initializer_list<std::string_view> paths) {
  for (const std::string_view path : paths) {
    if (path.empty() || path == "-") continue;
    if (const auto probe = AtomicPath::create(path); !probe) return probe.error();
  }
  return Done{};
}

}  // namespace accel::apps
