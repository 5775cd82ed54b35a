// Perfect hashes of a million random trees: Binder and Keller 2016, section 2.2.2, must never fail to place or to find a key.
//
//   hash_sweep [TREES [FIRST]]
//
// Tries so many trees from number FIRST on, and prints what kinds there were. Exit status: 0 ok; 1 one failed, and its number
// makes it again; 2 usage.
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <iterator>

#include <tbb/blocked_range.h>
#include <tbb/combinable.h>
#include <tbb/parallel_for.h>

#include "validation/stress/hash_trial.h"

namespace accel::validation {
namespace {

constexpr const char* kShapeNames[] = {"balanced", "random", "skewed", "left comb", "right comb", "chain", "zigzag"};
static_assert(std::size(kShapeNames) == std::size(kTreeShapes));

struct Sums {
  std::uint64_t trees = 0, keys = 0, bytes = 0, with_tables = 0, failed = 0;
  std::uint64_t by_width[3] = {};  // 32 bits, 64 bits, with overflow
  std::uint32_t max_depth = 0;

  void add(const HashTrial& trial) {
    ++trees, keys += trial.keys, bytes += trial.bytes, with_tables += trial.bytes > 0, failed += !trial.status;
    ++by_width[trial.depth <= kMaxDepth32 ? 0 : trial.depth <= kMaxDepth64 ? 1 : 2];
    max_depth = std::max(max_depth, trial.depth);
  }
  void add(const Sums& s) {
    trees += s.trees, keys += s.keys, bytes += s.bytes, with_tables += s.with_tables, failed += s.failed;
    for (int i = 0; i < 3; ++i) by_width[i] += s.by_width[i];
    max_depth = std::max(max_depth, s.max_depth);
  }
};
using SumsByShape = std::array<Sums, std::size(kTreeShapes)>;

SumsByShape sweep(std::uint64_t first, std::uint64_t count) {
  tbb::combinable<SumsByShape> parts;
  tbb::parallel_for(tbb::blocked_range<std::uint64_t>(first, first + count, 1000), [&](const auto& range) {
    SumsByShape& sums = parts.local();
    for (std::uint64_t number = range.begin(); number != range.end(); ++number) {
      const HashTrial trial = try_hash(number);
      sums[static_cast<std::size_t>(trial.shape)].add(trial);
      if (!trial.status)
        std::fprintf(stderr, "tree %llu: %s\n", static_cast<unsigned long long>(number), trial.status.message().c_str());
    }
  });
  SumsByShape all;
  parts.combine_each([&](const SumsByShape& part) {
    for (std::size_t i = 0; i < all.size(); ++i) all[i].add(part[i]);
  });
  return all;
}

void print_line(const char* name, const Sums& s) {
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf("%-10s %10llu %10llu %10llu %10llu %10llu %9u %10.2f %7llu\n", name, number(s.trees), number(s.with_tables),
              number(s.by_width[0]), number(s.by_width[1]), number(s.by_width[2]), s.max_depth,
              s.keys > 0 ? static_cast<double>(s.bytes) / static_cast<double>(s.keys) : 0.0, number(s.failed));
}

}  // namespace
}  // namespace accel::validation

int main(int argc, char** argv) {
  using namespace accel::validation;
  std::uint64_t numbers[] = {1000000, 0};  // trees, first
  bool good = argc <= 3;
  for (int i = 1; good && i < argc; ++i) {
    const char* const end = argv[i] + std::strlen(argv[i]);
    const auto parsed = std::from_chars(argv[i], end, numbers[i - 1]);
    good = parsed.ec == std::errc() && parsed.ptr == end;
  }
  if (!good) {
    std::fprintf(stderr, "usage: hash_sweep [TREES [FIRST]], two numbers\n");
    return 2;
  }

  std::printf("%-10s %10s %10s %10s %10s %10s %9s %10s %7s\n", "shape", "trees", "with hash", "32 bits", "64 bits", "overflow",
              "max depth", "bytes/node", "failed");
  Sums total;
  const SumsByShape sums = sweep(numbers[1], numbers[0]);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    print_line(kShapeNames[i], sums[i]);
    total.add(sums[i]);
  }
  print_line("all", total);
  return total.failed == 0 ? 0 : 1;
}
