// What is known about a structure of any kind: numbers for the reports.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libaccel/build/builder.h"
#include "libaccel/registry/any_structure.h"

namespace accel::apps {

struct StructureFacts {
  std::optional<double> sah_cost;
  std::optional<double> epo;  // end-point overlap; expensive
  std::optional<std::uint32_t> depth;
  std::optional<std::string> resolution;                     // cells of a grid
  std::optional<double> leaf_size_mean, leaf_size_variance;  // of leaves that are not empty
  std::optional<double> empty_leaf_share;
  std::optional<double> references_per_triangle;
  std::optional<std::uint64_t> inner_nodes, leaves;
  std::optional<double> expected_steps, expected_tests;  // of a random line
  std::vector<std::uint64_t> leaf_sizes;                 // [n]: leaves with n triangles; the last counts all larger ones too
  std::vector<std::uint64_t> leaf_depths;                // [d]: leaves below d inner nodes
  std::vector<std::pair<std::string, std::uint64_t>> arrays;  // what it consists of, in bytes
};

// `all` includes what is expensive to compute.
enum class Detail { quick, all };

// Costs are those of the options.
StructureFacts facts_of(const AnyStructure& structure, const BuildOptions& options, Detail detail);

}  // namespace accel::apps
