#include "libaccel/io/ply.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <atomic>
#include <cmath>
#include <utility>

#include "libaccel/io/face_list.h"
#include "libaccel/io/ply_cursor.h"
#include "libaccel/io/progress_ticker.h"

namespace accel {
namespace {

constexpr std::size_t kItemsBetweenTicks = 1 << 16;  // and in a parallel chunk
constexpr std::uint32_t kNoIndex = 0xffffffffu;
constexpr char kEndsEarly[] = "the line or the file ends early, or no number stands here";

// How an item of fixed size lies in a binary file: where its numbers are.
struct Field {
  std::size_t offset;
  PlyType type;
};

// Numbers of the types that nearly all files use, and of any type.
struct PlainFloat {
  explicit PlainFloat(Field, bool) {}
  float operator()(const std::byte* at) const { return load<float>(at, false); }
};
struct AnyFloat {
  AnyFloat(Field field, bool swap_bytes) : type(field.type), swap(swap_bytes) {}
  float operator()(const std::byte* at) const { return static_cast<float>(load_number(type, at, swap)); }
  PlyType type;
  bool swap;
};

// A vertex index from a number; kNoIndex for what cannot be one.
std::uint32_t to_index(double number) {
  return number >= 0 && number < kNoIndex && number == std::floor(number) ? static_cast<std::uint32_t>(number) : kNoIndex;
}
struct PlainIndex {
  explicit PlainIndex(PlyType, bool) {}
  std::uint32_t operator()(const std::byte* at) const { return load<std::uint32_t>(at, false); }
};
struct AnyIndex {
  AnyIndex(PlyType index_type, bool swap_bytes) : type(index_type), swap(swap_bytes) {}
  std::uint32_t operator()(const std::byte* at) const { return to_index(load_number(type, at, swap)); }
  PlyType type;
  bool swap;
};

void lower_to(std::atomic<std::uint64_t>& value, std::uint64_t candidate) {
  std::uint64_t current = value.load(std::memory_order_relaxed);
  while (candidate < current && !value.compare_exchange_weak(current, candidate, std::memory_order_relaxed)) {
  }
}

std::string bad_index(double number, std::uint64_t vertices) {
  char text[32];
  const auto [end, status] = std::to_chars(text, text + sizeof(text), number);
  return "names vertex " + std::string(text, end) + ", but the file has " + std::to_string(vertices) + " (counted from 0)";
}

class PlyReader {
 public:
  PlyReader(std::span<const std::byte> bytes, const std::string& name, const LoadOptions& options)
      : bytes_(bytes), name_(name), options_(options), ticker_(options.progress, "read") {}

  Result<TriangleMesh> read();

 private:
  Status check_header();
  template <class Cursor>
  Status read_elements(Cursor cursor);
  template <class Cursor>
  Status read_element(Cursor& cursor, const PlyElement& element);
  template <class Cursor>
  Status read_vertices(Cursor& cursor, const PlyElement& element);
  template <class Cursor>
  Status read_faces(Cursor& cursor, const PlyElement& element, std::uint64_t first);
  template <class Cursor>
  Status read_corners(Cursor& cursor, const PlyElement& element, std::uint64_t i);
  template <class Cursor>
  bool skip_property(Cursor& cursor, const PlyProperty& property);
  template <class Cursor>
  Status end_item(Cursor& cursor, const PlyElement& element, std::uint64_t i);

  // The fast paths of binary files.
  Status read_fixed_vertices(PlyBinaryCursor& cursor, const PlyElement& element);
  template <class Number>
  Status convert_vertices(const std::byte* first, std::size_t stride, const Field (&fields)[3], bool swap);
  Result<std::uint64_t> read_triangle_run(PlyBinaryCursor& cursor, const PlyElement& element);
  template <class Index>
  std::uint64_t convert_triangles(const std::byte* first, std::size_t stride, Field list, PlyType index_type, bool swap);

  Error interrupted() const { return Error{std::string(kInterrupted)}; }
  static std::string item_name(const PlyElement& element, std::uint64_t i) { return element.name + " " + std::to_string(i); }

  std::span<const std::byte> bytes_;
  const std::string& name_;
  const LoadOptions& options_;
  ProgressTicker ticker_;
  PlyHeader header_;
  int coordinates_[3] = {-1, -1, -1};  // properties of `vertex`
  int corner_list_ = -1;               // property of `face`
  std::uint64_t vertex_count_ = 0;

  Buffer<Vec3> vertices_;
  Buffer<IndexTriple> run_;  // triangles read by the fast path
  FaceList faces_;           // all others
  std::vector<std::uint32_t> corners_;
};

Result<TriangleMesh> PlyReader::read() {
  Result<PlyHeader> header = parse_ply_header(bytes_, name_);
  if (!header) return header.error();
  header_ = *std::move(header);
  if (Status status = check_header(); !status) return status.error();

  const Status body = header_.format == PlyFormat::ascii
                          ? read_elements(PlyAsciiCursor(bytes_, header_.size_bytes, name_))
                          : read_elements(PlyBinaryCursor(bytes_, header_.size_bytes, header_.swaps_bytes(), name_));
  if (!body) return body.error();

  Result<Buffer<IndexTriple>> triangles = faces_.triangulate(run_, vertices_.span(), name_);
  if (!triangles) return triangles.error();
  if (options_.skipped_faces != nullptr) *options_.skipped_faces += faces_.skipped();
  return TriangleMesh{std::move(vertices_), *std::move(triangles)};
}

Status PlyReader::check_header() {
  const PlyElement* vertex = header_.find("vertex");
  if (vertex == nullptr) return Error{name_ + ": has no element 'vertex'"};
  for (int k = 0; k < 3; ++k) {
    const std::string coordinate(1, "xyz"[k]);
    coordinates_[k] = vertex->find(coordinate);
    if (coordinates_[k] < 0 || vertex->properties[coordinates_[k]].count_type)
      return Error{name_ + ":" + std::to_string(vertex->line) + ": element 'vertex' has no number '" + coordinate + "'"};
  }
  vertex_count_ = vertex->count;
  if (vertex_count_ >= kNoIndex)
    return Error{name_ + ": has " + std::to_string(vertex_count_) + " vertices, more than 32 bits count"};

  const PlyElement* face = header_.find("face");
  if (face == nullptr && header_.find("tristrips") != nullptr)
    return Error{name_ + ": has triangle strips, which are not supported; convert them to faces"};
  if (face == nullptr) return Error{name_ + ": has no element 'face'; is it a point cloud?"};
  corner_list_ = face->find("vertex_indices", "vertex_index");
  if (face->count > 0 && (corner_list_ < 0 || !face->properties[corner_list_].count_type))
    return Error{name_ + ":" + std::to_string(face->line) + ": element 'face' has no list 'vertex_indices'"};
  return Done{};
}

template <class Cursor>
Status PlyReader::read_elements(Cursor cursor) {
  for (const PlyElement& element : header_.elements) {
    // Nothing is allocated for counts that the rest of the file cannot hold.
    const std::uint64_t least = element.least_bytes(header_.format);
    if (least == 0) continue;
    if (element.count > (cursor.remaining() + 1) / least)
      return cursor.error("element '" + element.name + "'", "says that it has " + std::to_string(element.count) +
                                                                " items, but the file ends after " +
                                                                std::to_string(cursor.remaining()) + " more bytes");
    if (Status status = read_element(cursor, element); !status) return status;
  }
  if (cursor.remaining() > 0)
    return cursor.error("after the last element", std::to_string(cursor.remaining()) + " bytes that belong to none");
  return Done{};
}

template <class Cursor>
Status PlyReader::read_element(Cursor& cursor, const PlyElement& element) {
  constexpr bool kBinary = std::is_same_v<Cursor, PlyBinaryCursor>;
  if constexpr (kBinary) {
    if (element.name == "vertex" && !element.has_lists()) return read_fixed_vertices(cursor, element);
    if (element.name == "face" && element.count > 0) {
      const Result<std::uint64_t> run = read_triangle_run(cursor, element);
      return run ? read_faces(cursor, element, *run) : Status(run.error());
    }
    const bool fixed = element.name != "face" && !element.has_lists();
    if (fixed && cursor.skip_bytes(element.count * element.least_bytes(header_.format))) return Done{};
    if (fixed) return cursor.error("element '" + element.name + "'", kEndsEarly);
  }
  if (element.name == "vertex") return read_vertices(cursor, element);
  if (element.name == "face") return read_faces(cursor, element, 0);
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties)
      if (!skip_property(cursor, property)) return cursor.error(item_name(element, i), kEndsEarly);
    if (Status status = end_item(cursor, element, i); !status) return status;
  }
  return Done{};
}

template <class Cursor>
bool PlyReader::skip_property(Cursor& cursor, const PlyProperty& property) {
  double count = 1;
  if (property.count_type && !cursor.number(*property.count_type, count)) return false;
  return count >= 0 && count <= static_cast<double>(cursor.room(property.type)) &&
         cursor.skip(property.type, static_cast<std::uint64_t>(count));
}

template <class Cursor>
Status PlyReader::end_item(Cursor& cursor, const PlyElement& element, std::uint64_t i) {
  if (!cursor.end_item()) return cursor.error(item_name(element, i), "the line goes on behind its last number");
  if (i % kItemsBetweenTicks == 0 && !ticker_.tick(cursor.fraction())) return interrupted();
  return Done{};
}

template <class Cursor>
Status PlyReader::read_vertices(Cursor& cursor, const PlyElement& element) {
  vertices_ = Buffer<Vec3>(element.count);
  for (std::uint64_t i = 0; i < element.count; ++i) {
    Vec3 position;
    for (int p = 0; p < static_cast<int>(element.properties.size()); ++p) {
      const int axis = p == coordinates_[0] ? 0 : p == coordinates_[1] ? 1 : p == coordinates_[2] ? 2 : -1;
      double value = 0;
      const PlyProperty& property = element.properties[p];
      if (!(axis >= 0 ? cursor.number(property.type, value) : skip_property(cursor, property)))
        return cursor.error(item_name(element, i), kEndsEarly);
      if (axis >= 0) position[axis] = static_cast<float>(value);
    }
    vertices_[i] = position;
    if (Status status = end_item(cursor, element, i); !status) return status;
  }
  return Done{};
}

template <class Cursor>
Status PlyReader::read_faces(Cursor& cursor, const PlyElement& element, std::uint64_t first) {
  for (std::uint64_t i = first; i < element.count; ++i) {
    for (int p = 0; p < static_cast<int>(element.properties.size()); ++p) {
      const PlyProperty& property = element.properties[p];
      if (p == corner_list_) {
        if (Status status = read_corners(cursor, element, i); !status) return status;
      } else if (!skip_property(cursor, property)) {
        return cursor.error(item_name(element, i), kEndsEarly);
      }
    }
    faces_.add(corners_);
    if (Status status = end_item(cursor, element, i); !status) return status;
  }
  return Done{};
}

template <class Cursor>
Status PlyReader::read_corners(Cursor& cursor, const PlyElement& element, std::uint64_t i) {
  const PlyProperty& property = element.properties[corner_list_];
  const auto error = [&](const std::string& what) { return cursor.error(item_name(element, i), what); };
  double count = 0;
  if (!cursor.number(*property.count_type, count)) return error(kEndsEarly);
  if (!(count >= 0 && count == std::floor(count))) return error("has a list of negative or broken length");
  if (count > static_cast<double>(cursor.room(property.type))) return error("has more corners than the rest of the file holds");

  corners_.clear();
  for (auto left = static_cast<std::uint64_t>(count); left > 0; --left) {
    double number = 0;
    if (!cursor.number(property.type, number)) return error(kEndsEarly);
    const std::uint32_t index = to_index(number);
    if (index >= vertex_count_) return error(bad_index(number, vertex_count_));
    corners_.push_back(index);
  }
  return Done{};
}

Status PlyReader::read_fixed_vertices(PlyBinaryCursor& cursor, const PlyElement& element) {
  const std::size_t stride = element.least_bytes(header_.format);
  const std::byte* first = cursor.here();
  if (element.count > cursor.remaining() / stride || !cursor.skip_bytes(element.count * stride))
    return cursor.error("element 'vertex'", "the file ends before its last vertex");

  Field fields[3];
  bool plain = !cursor.swaps_bytes();
  for (int k = 0; k < 3; ++k) {
    std::size_t offset = 0;
    for (int p = 0; p < coordinates_[k]; ++p) offset += size_of(element.properties[p].type);
    fields[k] = {offset, element.properties[coordinates_[k]].type};
    plain = plain && fields[k].type == PlyType::float32;
  }
  vertices_ = Buffer<Vec3>(element.count);
  return plain ? convert_vertices<PlainFloat>(first, stride, fields, false)
               : convert_vertices<AnyFloat>(first, stride, fields, cursor.swaps_bytes());
}

template <class Number>
Status PlyReader::convert_vertices(const std::byte* first, std::size_t stride, const Field (&fields)[3], bool swap) {
  const Number x(fields[0], swap), y(fields[1], swap), z(fields[2], swap);
  Vec3* vertices = vertices_.data();
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices_.size(), kItemsBetweenTicks), [&](const auto& range) {
    if (!ticker_.tick(static_cast<double>(first - bytes_.data() + range.begin() * stride) / bytes_.size())) return;
    const std::byte* item = first + range.begin() * stride;
    for (std::size_t i = range.begin(); i < range.end(); ++i, item += stride)
      vertices[i] = {x(item + fields[0].offset), y(item + fields[1].offset), z(item + fields[2].offset)};
  });
  return ticker_.stopped() ? Status(interrupted()) : Done{};
}

// Reads the triangles that begin a face element, as long as only triangles follow each other; returns how many.
Result<std::uint64_t> PlyReader::read_triangle_run(PlyBinaryCursor& cursor, const PlyElement& element) {
  const PlyProperty& list = element.properties[corner_list_];
  std::size_t stride = 0, list_offset = 0;
  for (int p = 0; p < static_cast<int>(element.properties.size()); ++p) {
    const PlyProperty& property = element.properties[p];
    if (p == corner_list_) list_offset = stride;
    if (p != corner_list_ && property.count_type) return std::uint64_t{0};  // a second list: items of any size
    stride += p == corner_list_ ? size_of(*property.count_type) + 3 * size_of(property.type) : size_of(property.type);
  }

  const std::uint64_t most = std::min<std::uint64_t>(element.count, cursor.remaining() / stride);
  if (most > kMaxTriangles)
    return Error{name_ + ": has more than " + std::to_string(kMaxTriangles) + " triangles, the limit; split it"};
  run_ = Buffer<IndexTriple>(most);
  const bool plain = !cursor.swaps_bytes() && (list.type == PlyType::int32 || list.type == PlyType::uint32);
  const Field length{list_offset, *list.count_type};
  const std::uint64_t run = plain ? convert_triangles<PlainIndex>(cursor.here(), stride, length, list.type, false)
                                  : convert_triangles<AnyIndex>(cursor.here(), stride, length, list.type, cursor.swaps_bytes());
  if (ticker_.stopped()) return interrupted();
  run_.truncate(run);
  cursor.skip_bytes(run * stride);
  return run;
}

// Converts triangles up to the first face that is none, or that has an index out of range; returns its number. (The general
// path then reads that face again, and says what is wrong with it.)
template <class Index>
std::uint64_t PlyReader::convert_triangles(const std::byte* first, std::size_t stride, Field list, PlyType index_type,
                                           bool swap) {
  const Index index(index_type, swap);
  const std::size_t length_bytes = size_of(list.type), index_bytes = size_of(index_type);
  const bool byte_length = length_bytes == 1;
  const std::uint64_t vertex_count = vertex_count_;
  IndexTriple* triangles = run_.data();
  std::atomic<std::uint64_t> end{run_.size()};
  tbb::parallel_for(tbb::blocked_range<std::uint64_t>(0, run_.size(), kItemsBetweenTicks), [&](const auto& range) {
    const std::byte* item = first + range.begin() * stride + list.offset;
    if (end.load(std::memory_order_relaxed) <= range.begin()) return;
    if (!ticker_.tick(static_cast<double>(item - bytes_.data()) / bytes_.size())) return;
    for (std::uint64_t i = range.begin(); i < range.end(); ++i, item += stride) {
      const std::byte* corner = item + length_bytes;
      const IndexTriple t{index(corner), index(corner + index_bytes), index(corner + 2 * index_bytes)};
      const bool three = byte_length ? item[0] == std::byte{3} : load_number(list.type, item, swap) == 3;
      if (!three || std::max({t.v0, t.v1, t.v2}) >= vertex_count) return lower_to(end, i);
      triangles[i] = t;
    }
  });
  return end.load();
}

}  // namespace

Result<TriangleMesh> parse_ply(std::span<const std::byte> bytes, const std::string& name, const LoadOptions& options) {
  return PlyReader(bytes, name, options).read();
}

}  // namespace accel
