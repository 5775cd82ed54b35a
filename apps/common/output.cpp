#include "apps/common/output.h"

#include "libaccel/io/atomic_file.h"

namespace accel::apps {

Finished write_text(const std::string& path, std::string_view text) {
  if (const Status written = write_file(path, text); !written) return written.error();
  return Done{};
}

}  // namespace accel::apps
