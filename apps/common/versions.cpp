#include "apps/common/versions.h"

#include "apps/common/image.h"
#include "apps/common/report_html.h"
#include "apps/common/text.h"
#include "libaccel/core/version.h"
#include "validation/oracle/embree.h"

namespace accel::apps {

std::vector<std::pair<std::string, std::string>> versions() {
  return {{"libaccel", kVersion},
          {"compiler", ACCEL_COMPILER},
          {"embree", validation::EmbreeWitness::version()},
          {"images", image_library_version()},
          {"plots", report_plots_version()}};
}

std::string versions_text(const std::string& program) {
  std::string text = program + " " + kVersion + "\n";
  for (const auto& [name, version] : versions())
    if (name != "libaccel") text += print("  %-9s %s\n", name.c_str(), version.c_str());
  return text;
}

}  // namespace accel::apps
