// What is known about a structure of any kind: numbers for the reports.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "libaccel/build/builder.h"
#include "libaccel/core/result.h"
#include "libaccel/registry/any_structure.h"

namespace accel::apps {

struct StructureFacts {
  std::optional<double> sah_cost;
  std::optional<double> epo;  // end-point overlap; expensive
  std::optional<std::uint32_t> depth;
  std::vector<std::uint64_t> leaf_sizes;   // [n]: leaves with n triangles
  std::vector<std::uint64_t> leaf_depths;  // [d]: leaves below d inner nodes
};

// `all` includes what is expensive to compute.
enum class Detail { quick, all };

// Errors: interrupted, by the options' progress callback.
Result<StructureFacts> facts_of(const AnyStructure& structure, const TriangleMesh& mesh, const BuildOptions& options,
                                Detail detail);

}  // namespace accel::apps
