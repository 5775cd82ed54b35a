// The repro bundle: everything that is needed to look at a failure again, in three files beside each other.
//
//   STEM.txt       for people: the command line, one that finds the failures again, and for each case its ray, the answers and
//   verdicts, the exact hit, and
//                  every triangle involved with what rounding may make of it (error_bounds.h). Numbers in hexadecimal, exact,
//                  and in decimal.
//   STEM-rays.npy  the rays, for `accel-trace SCENE --rays STEM-rays.npy`
//   STEM.obj       the triangles involved, with enough digits to read the same floats back; to be traced with brute/loop
//
// Each file is written whole or not at all.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "validation/compare/compare.h"

namespace accel::validation {

struct ReproCase {
  std::size_t ray_number = 0;  // in the batch
  Ray ray;
  Verdict verdict = Verdict::unjudged;
  Hit ours;  // for any-hit queries only hit or miss is meaningful
  std::optional<Hit> witness;
};

struct ReproContext {
  std::string command_line;  // what found the failure
  std::string scene;         // as accel-trace takes it
  std::string method;        // likewise
  Query query = Query::closest;
  std::vector<std::string> options;  // all others that decide hits: the test, the seed of the scene, of builds and packets
};

// The failures that a comparison listed, with the batch it was made from. `witness` may be empty.
std::vector<ReproCase> repro_cases(const CheckResult& result, std::span<const Ray> rays, std::span<const Hit> ours,
                                   std::span<const Hit> witness);
std::vector<ReproCase> repro_cases(const CheckResult& result, std::span<const Ray> rays, std::span<const std::uint8_t> ours,
                                   std::span<const std::uint8_t> witness);

// Writes the bundle; `stem` is a path without extension. Returns the path of the text.
Result<std::filesystem::path> write_repro(const std::filesystem::path& stem, const Judge& judge,
                                          std::span<const ReproCase> cases, const ReproContext& context);

}  // namespace accel::validation
