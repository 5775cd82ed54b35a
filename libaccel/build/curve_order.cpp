#include "libaccel/build/curve_order.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "libaccel/build/radix_sort.h"
#include "libaccel/core/morton.h"

namespace accel {
namespace {

constexpr int kAxisBits = 21, kCodeBits = 3 * kAxisBits;
constexpr int kLowBits = 32;           // left to the second round
constexpr std::size_t kFewCodes = 64;  // sorted by insertion

// Cells along the widest axis of the centres; one where all are the same.
class CurveCells {
 public:
  explicit CurveCells(const Box4& centers) : base_(centers.lo) {
    const Vec3 extent = (centers.hi - centers.lo).xyz();
    const float widest = std::max({extent.x, extent.y, extent.z});
    constexpr float kCells = 1u << kAxisBits;
    scale_ = Float4::splat(widest > 0 ? std::min(kCells / widest, std::numeric_limits<float>::max()) : 0.0f);
  }
  std::uint64_t code(const Box4& box) const {
    std::int32_t cell[4];
    const Float4 last = Float4::splat(static_cast<float>((1u << kAxisBits) - 1u));  // exact
    min_of(max_of((doubled_center(box) - base_) * scale_, Float4::splat(0.0f)), last).truncate_to(cell);
    return morton_3d(static_cast<std::uint32_t>(cell[0]), static_cast<std::uint32_t>(cell[1]),
                     static_cast<std::uint32_t>(cell[2]));
  }

 private:
  Float4 base_, scale_;
};

void sort_by_insertion(std::uint64_t* codes, std::uint32_t* ids, std::size_t n) {
  for (std::size_t i = 1; i < n; ++i) {
    const std::uint64_t code = codes[i];
    const std::uint32_t id = ids[i];
    std::size_t to = i;
    for (; to > 0 && code < codes[to - 1]; --to) codes[to] = codes[to - 1], ids[to] = ids[to - 1];
    codes[to] = code, ids[to] = id;
  }
}

struct CodeRun {
  std::size_t begin, end;
};

// The runs of equal upper bits that start in [begin, end) and have something to sort.
std::vector<CodeRun> runs_in(const std::uint64_t* codes, std::size_t n, std::size_t begin, std::size_t end) {
  const auto is_same = [&](std::size_t i, std::size_t j) { return codes[i] >> kLowBits == codes[j] >> kLowBits; };
  std::vector<CodeRun> runs;
  std::size_t i = begin;
  while (i > 0 && i < end && is_same(i, i - 1)) ++i;
  for (std::size_t last; i < end; i = last) {
    for (last = i + 1; last < n && is_same(i, last);) ++last;
    if (last > i + 1) runs.push_back({i, last});
  }
  return runs;
}

void sort_codes(std::uint64_t* codes, std::uint32_t* ids, std::size_t n) {
  radix_sort(codes, ids, n, kLowBits, kCodeBits);
  std::vector<std::vector<CodeRun>> runs(chunk_count(n));
  for_chunks(0, n, [&](std::size_t chunk, std::size_t begin, std::size_t end) { runs[chunk] = runs_in(codes, n, begin, end); });
  tbb::parallel_for(std::size_t{0}, runs.size(), [&](std::size_t chunk) {
    for (const CodeRun& run : runs[chunk])
      if (const std::size_t size = run.end - run.begin; size <= kFewCodes) {
        sort_by_insertion(codes + run.begin, ids + run.begin, size);
      } else {
        radix_sort(codes + run.begin, ids + run.begin, size, 0, kLowBits);
      }
  });
}

}  // namespace

Buffer<Reference> in_curve_order(BuildContext& context, References& references) {
  context.begin_phase("sort");
  const std::size_t n = references.count;
  Buffer<std::uint64_t> codes(n);
  Buffer<std::uint32_t> ids(n);
  const std::size_t pairs = 2 * (codes.size_bytes() + ids.size_bytes());
  context.memory.add(pairs);

  const CurveCells cells(references.bounds.centers);
  for_chunks(0, n, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      codes[i] = cells.code(references.storage[i].box()), ids[i] = static_cast<std::uint32_t>(i);
  });
  sort_codes(codes.data(), ids.data(), n);

  Buffer<Reference> sorted(n);
  context.memory.add(sorted.size_bytes());
  for_chunks(0, n, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) sorted[i] = references.storage[ids[i]];
  });
  context.memory.subtract(pairs + references.storage.size_bytes());
  references.storage = {};
  return sorted;
}

}  // namespace accel
