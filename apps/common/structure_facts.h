// What is known about a structure of any kind: numbers for the reports.
#pragma once

#include <cstdint>
#include <optional>

#include "libaccel/registry/any_structure.h"

namespace accel::apps {

struct StructureFacts {
  std::optional<double> sah_cost;
  std::optional<std::uint32_t> depth;
  std::uint64_t nodes = 0, leaves = 0;
};

StructureFacts facts_of(const AnyStructure& structure, const BuildOptions& options);

}  // namespace accel::apps
