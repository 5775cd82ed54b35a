#include "libaccel/build/curve_order.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <vector>

#include <tbb/parallel_sort.h>

#include "libaccel/build/parallel.h"
#include "libaccel/build/sort_words.h"
#include "libaccel/core/morton.h"
#include "libaccel/structure/triangle_block.h"

namespace accel {
namespace {

constexpr int kAxisBits = 21;
constexpr int kFirstBit = 20;                // of four digits: those above are sorted first
constexpr std::size_t kShort = kBlockLanes;  // runs that stay as they are
constexpr std::size_t kFew = 32;             // likewise, of words that are the same but for their number

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

// Words: codes are 63 bits long, and those of nothing have the bit above.
class Sorter {
 public:
  Sorter(const References& references)
      : references_(references.storage),
        cells_(references.bounds.centers),
        count_(references.count),
        id_bits_(std::bit_width(references_.size() - 1)) {}

  CurveOrder run() {
    const std::size_t n = references_.size();
    Buffer<std::uint64_t> words(n), other(n);
    for_chunks(0, n, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) words[i] = word(static_cast<std::uint32_t>(i));
    });
    if (sort_words(words.data(), other.data(), n, kFirstBit) != words.data()) std::swap(words, other);
    sort_runs(words.data());
    return {std::move(words), count_, id_bits_};
  }

 private:
  std::uint64_t word(std::uint32_t id) const {
    const Box4 box = references_[id].box();
    if (box.empty()) return std::uint64_t{1} << 63 | id;
    return cells_.code(box) >> id_bits_ << id_bits_ | id;
  }
  std::uint64_t code(std::uint64_t word) const {
    return cells_.code(references_[word & ((std::uint64_t{1} << id_bits_) - 1)].box());
  }

  struct Run {
    std::size_t begin, end;
  };

  // Sorts the long runs of equal upper bits by all of them. Who looks for runs reads those that end in his chunk, so none is
  // sorted until all are found.
  void sort_runs(std::uint64_t* words) const {
    std::vector<std::vector<Run>> runs(chunk_count(count_));
    for_chunks(0, count_,
               [&](std::size_t chunk, std::size_t begin, std::size_t end) { runs[chunk] = long_runs(words, begin, end); });
    tbb::parallel_for(std::size_t{0}, runs.size(), [&](std::size_t chunk) {
      for (const Run& run : runs[chunk]) sort_run(words + run.begin, words + run.end);
    });
  }
  // Those that start in [begin, end).
  std::vector<Run> long_runs(const std::uint64_t* words, std::size_t begin, std::size_t end) const {
    std::vector<Run> runs;
    const auto is_same = [&](std::size_t i, std::size_t j) { return words[i] >> kFirstBit == words[j] >> kFirstBit; };
    std::size_t i = begin;
    while (i > 0 && i < end && is_same(i, i - 1)) ++i;
    while (i < end && i + kShort < count_) {
      std::size_t last = i + kShort;
      if (!is_same(i, last)) {  // no long run begins here
        ++i;
        continue;
      }
      while (last < count_ && is_same(i, last)) ++last;
      runs.push_back({i, last});
      i = last;
    }
    return runs;
  }
  // By all threads where it is long: a scene may be a point beside something far away.
  template <class Value>
  static void sort_all(Value* begin, Value* end) {
    if (static_cast<std::size_t>(end - begin) < kParallelSize)
      std::sort(begin, end);
    else
      tbb::parallel_sort(begin, end);
  }
  void sort_run(std::uint64_t* begin, std::uint64_t* end) const {
    sort_all(begin, end);  // numbers break ties
    for (std::uint64_t *first = begin, *last; first < end; first = last) {
      for (last = first + 1; last < end && *first >> id_bits_ == *last >> id_bits_;) ++last;
      if (static_cast<std::size_t>(last - first) > kFew) sort_by_code(first, last);
    }
  }
  void sort_by_code(std::uint64_t* begin, std::uint64_t* end) const {
    std::vector<std::pair<std::uint64_t, std::uint64_t>> coded;
    coded.reserve(static_cast<std::size_t>(end - begin));
    for (const std::uint64_t* at = begin; at < end; ++at) coded.emplace_back(code(*at), *at);
    sort_all(coded.data(), coded.data() + coded.size());
    for (const auto& pair : coded) *begin++ = pair.second;
  }

  const Buffer<Reference>& references_;
  const CurveCells cells_;
  const std::size_t count_;
  const int id_bits_;
};

}  // namespace

CurveOrder curve_order(BuildContext& context, const References& references) {
  context.begin_phase("sort");
  const std::size_t words = references.storage.size() * sizeof(std::uint64_t);
  context.memory.add(2 * words);
  CurveOrder order = Sorter(references).run();
  context.memory.subtract(words);
  return order;
}

Buffer<Reference> in_order(const References& references, const CurveOrder& order) {
  Buffer<Reference> sorted(order.size());
  for_chunks(0, order.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) sorted[i] = references.storage[order[i]];
  });
  return sorted;
}

}  // namespace accel
