#include "libaccel/packet/block_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>

#include "libaccel/packet/frustums_simd.h"
#include "libaccel/packet/pixel_rows.h"
#include "libaccel/packet/serial_primitives.h"

namespace accel {

namespace {

constexpr std::size_t kRunAsTheyCome = 8;  // rays that are placed together where nothing is sorted

// Where the faces [first, end) end to be the first one. Eight at a time, since most runs have one face.
std::size_t end_of_face(const std::uint8_t* faces, std::size_t first, std::size_t end) {
  const std::uint64_t eight = faces[first] * 0x0101010101010101ull;
  std::size_t next = first;
  for (std::uint64_t some; next + 8 <= end; next += 8) {
    std::memcpy(&some, faces + next, sizeof some);
    if (some != eight) break;
  }
  if (std::uint32_t four; next + 4 <= end) {
    std::memcpy(&four, faces + next, sizeof four);
    if (four == static_cast<std::uint32_t>(eight)) next += 4;
  }
  while (next < end && faces[next] == faces[first]) ++next;
  return next;
}

// So many numbers from `first` on: a count that compilers know is written as a vector.
template <std::size_t kCount>
void append(std::size_t first, std::uint32_t* to) {
  for (std::size_t i = 0; i < kCount; ++i) to[i] = static_cast<std::uint32_t>(first + i);
}

// body(first, end): the rays [first, end), in pieces of one face.
template <class Body>
void for_each_piece(const std::uint8_t* faces, std::size_t first, std::size_t end, const Body& body) {
  for (std::size_t next; first < end; first = next) body(first, next = end_of_face(faces, first, end));
}

// Tiles of 16 x 16 pixels, each of them 16 tiles of 4 x 4, which are what fits the widest vectors: calls body(run) for the runs
// of kTileRun rays, of n that come in rows. Whole tiles come first, as each of them is a packet then; what is left at the edges
// of the block comes behind.
constexpr std::size_t kTileRun = 4;

template <class Body>
class Tiles {
 public:
  Tiles(PixelRows rows, std::size_t n, const Body& body)
      : first_(static_cast<std::ptrdiff_t>(rows.first)),
        length_(static_cast<std::ptrdiff_t>(rows.length)),
        count_(static_cast<std::ptrdiff_t>(n)),
        body_(body) {}

  void list() const {
    const std::ptrdiff_t band = kTile * length_, whole = length_ / kTile * kTile,
                         end = first_ + (count_ - first_) / band * band;
    for (std::ptrdiff_t top = first_; top < end; top += band) list_rows(top, kTile, 0, whole);
    for (std::ptrdiff_t top = first_; top < end; top += band) list_rows(top, kTile, whole, length_);
    list_rows(end, (count_ - end + length_ - 1) / length_, 0, length_);
    list_rows(first_ - length_, 1, 0, length_);
  }

 private:
  static constexpr std::ptrdiff_t kRun = kTileRun, kTile = 16;

  // Columns [begin, end) of so many rows, the first of which begins at ray `top`, before which there may be none.
  void list_rows(std::ptrdiff_t top, std::ptrdiff_t height, std::ptrdiff_t begin, std::ptrdiff_t end) const {
    for (std::ptrdiff_t tile = begin; tile < end; tile += kTile)
      for (std::ptrdiff_t y = 0; y < height; y += kRun)
        list_strip(top + y * length_, std::min(kRun, height - y), tile, std::min(tile + kTile, end));
  }
  void list_strip(std::ptrdiff_t top, std::ptrdiff_t height, std::ptrdiff_t begin, std::ptrdiff_t end) const {
    for (std::ptrdiff_t x = begin; x < end; x += kRun)
      for (std::ptrdiff_t y = 0; y < height; ++y) list_run(top + y * length_, x);
  }
  // The run that begins in column x of a row or next to it, if that is in the row.
  void list_run(std::ptrdiff_t row, std::ptrdiff_t x) const {
    const std::ptrdiff_t first = (row + x + kRun * length_ + kRun - 1) / kRun * kRun - kRun * length_;
    if (first >= 0 && first < std::min(row + length_, count_)) body_(static_cast<std::size_t>(first / kRun));
  }

  std::ptrdiff_t first_, length_, count_;
  const Body& body_;
};

// Lists rays by face, of which those of each come from a given place on.
class Placer {
 public:
  using Places = std::array<std::uint32_t, kNoFace + 1>;

  Placer(const std::uint8_t* faces, std::size_t n, std::size_t run, const Places& places, std::uint32_t* ids)
      : faces_(faces),
        n_(n),
        run_(run),
        mask_(run >= 8 ? ~0ull : (1ull << 8 * run) - 1),
        places_(places),
        ids_(ids),
        to_(ids + places[0]) {}

  // The rays of a run. Most have the face of the run before.
  void place(std::size_t r) {
    const std::size_t first = r * run_;
    if (first + 8 <= n_ && (run_ == 8 || run_ == kTileRun)) {
      std::uint64_t some;
      std::memcpy(&some, faces_ + first, sizeof some);
      if (((some ^ expected_) & mask_) == 0) {
        run_ == 8 ? append<8>(first, to_) : append<kTileRun>(first, to_);
        to_ += run_;
        return;
      }
    }
    for_each_piece(faces_, first, std::min(first + run_, n_), [this](std::size_t begin, std::size_t end) {
      if (faces_[begin] != face_) set_face(faces_[begin]);
      for (std::size_t id = begin; id < end; ++id) *to_++ = static_cast<std::uint32_t>(id);
    });
  }

 private:
  void set_face(std::uint8_t face) {
    places_[face_] = static_cast<std::uint32_t>(to_ - ids_);
    face_ = face, expected_ = face * 0x0101010101010101ull, to_ = ids_ + places_[face];
  }

  const std::uint8_t* faces_;
  std::size_t n_, run_;
  std::uint64_t mask_, expected_ = 0;  // of a run's bytes in faces_: those that count, and those of the face
  Places places_;
  std::uint32_t* const ids_;
  std::uint32_t* to_;      // where the next ray of the face goes
  std::uint8_t face_ = 0;  // of the run before
};

}  // namespace

void BlockOrder::begin(std::span<const Ray> rays) {
  rays_ = rays;
  faces_by_ray_.resize(rays.size());
  find_faces_simd(rays.data(), rays.size(), faces_by_ray_.data());
}

void BlockOrder::sort(std::uint32_t run) {
  const std::size_t n = rays_.size();
  if (run == 0)
    return place_runs(kRunAsTheyCome, [n](const auto& place) {
      for (std::size_t r = 0; r * kRunAsTheyCome < n; ++r) place(r);
    });
  if (const PixelRows rows = find_rows(rays_, inv_diagonal_); rows.length > 0)
    return place_runs(kTileRun, [&](const auto& place) { Tiles(rows, n, place).list(); });
  sort_runs(run);
  place_runs(run, [this](const auto& place) { std::for_each(runs_.begin(), runs_.end(), place); });
}

// By the highest bits in which their values differ: more make no better packets, and each eight are a pass over the runs.
void BlockOrder::sort_runs(std::uint32_t run) {
  const std::size_t n = rays_.size(), count = (n + run - 1) / run;
  values_.resize(count), keys_.resize(count), runs_.resize(count);
  for (std::size_t r = 0; r < count; ++r) runs_[r] = static_cast<std::uint32_t>(std::min(r * run + run / 2, n - 1));
  hash_rays_simd(hash_, rays_.data(), runs_.data(), count, values_.data());
  std::uint64_t differ = 0;
  for (std::size_t r = 0; r < count; ++r) differ |= values_[r] ^ values_[0];
  const int shift = std::max(0, static_cast<int>(std::bit_width(differ)) - kKeyBits);
  for (std::size_t r = 0; r < count; ++r) keys_[r] = static_cast<std::uint32_t>(values_[r] >> shift) & ((1u << kKeyBits) - 1);
  std::iota(runs_.begin(), runs_.end(), 0u);
  SerialPrimitives::sort_pairs(keys_.data(), runs_.data(), count);
}

// Lists the rays by face, and those of a face in the order in which for_each_run(place) calls place(run). Most runs have one
// face, and go there as a whole.
template <class ForEachRun>
void BlockOrder::place_runs(std::size_t run, const ForEachRun& for_each_run) {
  const std::size_t n = rays_.size();
  const std::uint8_t* const faces = faces_by_ray_.data();
  std::array<std::uint32_t, kNoFace + 1> places{};
  for_each_piece(faces, 0, n,
                 [&](std::size_t first, std::size_t end) { places[faces[first]] += static_cast<std::uint32_t>(end - first); });
  ids_.resize(n), faces_.clear();
  for (std::size_t face = 0; face < places.size(); ++face)
    faces_.insert(faces_.end(), places[face], static_cast<std::uint8_t>(face));
  std::exclusive_scan(places.begin(), places.end(), places.begin(), 0u);
  Placer placer(faces, n, run, places, ids_.data());
  for_each_run([&](std::size_t r) { placer.place(r); });
}

void BlockOrder::keep(std::span<const std::pair<std::uint32_t, std::uint32_t>> places) {
  std::size_t kept = 0;
  for (const auto& [first, end] : places) {
    std::copy(ids_.begin() + first, ids_.begin() + end, ids_.begin() + static_cast<std::ptrdiff_t>(kept));
    std::copy(faces_.begin() + first, faces_.begin() + end, faces_.begin() + static_cast<std::ptrdiff_t>(kept));
    kept += end - first;
  }
  ids_.resize(kept), faces_.resize(kept);
}

}  // namespace accel
