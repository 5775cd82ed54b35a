#include "libaccel/io/npy.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libaccel/core/out_of_memory.h"
#include "libaccel/io/atomic_file.h"
#include "libaccel/io/load_bytes.h"
#include "libaccel/io/mapped_file.h"

namespace accel {
namespace {

constexpr std::string_view kNpyMagic = "\x93NUMPY";
constexpr std::string_view kHitFields = "[('t', '<f4'), ('u', '<f4'), ('v', '<f4'), ('prim_id', '<u4')]";
static_assert(std::endian::native == std::endian::little, "the arrays are written as they lie in memory");

// What the header says.
struct NpyHeader {
  std::string descr;  // without blanks; strings in single quotes
  bool fortran_order = false;
  std::vector<std::uint64_t> shape;
  std::size_t size_bytes = 0;  // the data begins here
};

// The header is a Python dictionary of three literals. Read is the part of the language that numpy writes: strings, True and
// False, tuples, lists and numbers.
class DictParser {
 public:
  explicit DictParser(std::string_view text) : text_(text) {}

  // Fills descr, fortran_order and shape; false when the text is anything else.
  bool parse(NpyHeader& header) {
    if (!take('{')) return false;
    int seen = 0;
    while (!take('}')) {
      std::string key;
      if (!string(key) || !take(':') || !value(key, header, seen)) return false;
      if (!take(',') && !peek('}')) return false;
    }
    skip_blanks();
    return seen == 7 && text_.empty();
  }

 private:
  bool value(const std::string& key, NpyHeader& header, int& seen) {
    const int bit = key == "descr" ? 1 : key == "fortran_order" ? 2 : key == "shape" ? 4 : 0;
    if (bit == 0 || (seen & bit) != 0) return false;
    seen |= bit;
    return bit == 1 ? literal(header.descr) : bit == 2 ? boolean(header.fortran_order) : tuple(header.shape);
  }

  void skip_blanks() { text_.remove_prefix(std::min(text_.find_first_not_of(" \t\r\n"), text_.size())); }
  bool peek(char c) { return skip_blanks(), text_.starts_with(c); }
  bool take(char c) { return peek(c) && (text_.remove_prefix(1), true); }

  bool string(std::string& out) {
    if (!peek('\'') && !peek('"')) return false;
    const std::size_t end = text_.find(text_[0], 1);
    if (end == std::string_view::npos) return false;
    out = text_.substr(1, end - 1);
    text_.remove_prefix(end + 1);
    return true;
  }

  bool boolean(bool& out) {
    skip_blanks();
    out = text_.starts_with("True");
    if (!out && !text_.starts_with("False")) return false;
    text_.remove_prefix(out ? 4 : 5);
    return true;
  }

  bool tuple(std::vector<std::uint64_t>& out) {
    constexpr std::size_t kMostDimensions = 32;
    if (!take('(')) return false;
    while (!take(')')) {
      skip_blanks();
      std::uint64_t length = 0;
      const auto [end, status] = std::from_chars(text_.data(), text_.data() + text_.size(), length);
      if (status != std::errc() || out.size() == kMostDimensions) return false;
      text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
      out.push_back(length);
      if (!take(',') && !peek(')')) return false;
    }
    return true;
  }

  // A string, or a list of fields; kept as text, in one spelling.
  bool literal(std::string& out) {
    if (peek('\'') || peek('"')) {
      std::string value;
      if (!string(value)) return false;
      out += "'" + value + "'";
      return true;
    }
    if (!take('[')) return false;
    for (out += '['; !take(']');) {
      std::string name, type;
      if (!take('(') || !string(name) || !take(',') || !string(type)) return false;
      if ((take(','), !take(')'))) return false;
      out += (out.size() > 1 ? ", ('" : "('") + name + "', '" + type + "')";
      if (!take(',') && !peek(']')) return false;
    }
    out += ']';
    return true;
  }

  std::string_view text_;
};

Result<NpyHeader> parse_header(std::span<const std::byte> bytes, const std::string& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!text.starts_with(kNpyMagic) || text.size() < 12) return Error{name + ": is not a .npy file"};

  // Version 1.0 has 16 bits for the header's length, 2.0 and 3.0 have 32.
  const int version = static_cast<unsigned char>(text[6]);
  if (version < 1 || version > 3 || text[7] != 0)
    return Error{name + ": .npy version " + std::to_string(version) + "." +
                 std::to_string(static_cast<unsigned char>(text[7])) + " is not known"};
  const std::size_t start = version == 1 ? 10 : 12;
  const std::uint64_t length = version == 1 ? load<std::uint16_t>(&bytes[8]) : load<std::uint32_t>(&bytes[8]);
  if (length > text.size() - start) return Error{name + ": the file ends within its header"};

  NpyHeader header;
  if (!DictParser(text.substr(start, length)).parse(header)) return Error{name + ": the .npy header is damaged"};
  header.size_bytes = start + length;
  return header;
}

std::string shape_text(const std::vector<std::uint64_t>& shape) {
  std::string text = "(";
  for (std::size_t i = 0; i < shape.size(); ++i) text += (i > 0 ? ", " : "") + std::to_string(shape[i]);
  return text + (shape.size() == 1 ? ",)" : ")");
}

// Whether the file holds exactly `rows` rows of `row_bytes` behind its header.
Status check_size(const NpyHeader& header, std::size_t file_size, std::uint64_t row_bytes, const std::string& name) {
  const std::uint64_t data = file_size - header.size_bytes;
  if (header.shape[0] == data / row_bytes && data % row_bytes == 0) return Done{};
  return Error{name + ": shape " + shape_text(header.shape) + " does not fit the file, whose data has " + std::to_string(data) +
               " bytes; is it truncated?"};
}

// The numbers of a plain array of one of the four float types, as float.
class FloatMatrix {
 public:
  static std::optional<FloatMatrix> make(const NpyHeader& header, const std::byte* data) {
    const bool big = header.descr == "'>f4'" || header.descr == "'>f8'";
    const bool wide = header.descr == "'<f8'" || header.descr == "'>f8'";
    if (!big && !wide && header.descr != "'<f4'") return std::nullopt;
    return FloatMatrix(data, header.shape, header.fortran_order, big, wide);
  }

  std::size_t number_bytes() const { return wide_ ? 8 : 4; }

  float at(std::uint64_t row, std::uint64_t column) const {
    const std::byte* number = data_ + (row * row_stride_ + column * column_stride_) * number_bytes();
    return wide_ ? static_cast<float>(load<double>(number, swap_)) : load<float>(number, swap_);
  }

 private:
  FloatMatrix(const std::byte* data, const std::vector<std::uint64_t>& shape, bool fortran, bool big, bool wide)
      : data_(data), row_stride_(fortran ? 1 : shape[1]), column_stride_(fortran ? shape[0] : 1), swap_(big), wide_(wide) {}

  const std::byte* data_;
  std::uint64_t row_stride_, column_stride_;
  bool swap_, wide_;
};

Status write_npy(const std::filesystem::path& path, std::string_view descr, const std::vector<std::uint64_t>& shape,
                 std::span<const std::byte> data) {
  std::string dict = "{'descr': " + std::string(descr) + ", 'fortran_order': False, 'shape': " + shape_text(shape) + ", }";
  // Padded with blanks, so that the data begins at a multiple of 64.
  constexpr std::size_t kPrefix = 10;
  dict.append(63 - (kPrefix + dict.size()) % 64, ' ');
  dict += '\n';
  std::string prefix(kNpyMagic);
  prefix += {1, 0, static_cast<char>(dict.size() & 0xff), static_cast<char>(dict.size() >> 8)};

  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  if (Status status = file->write(prefix + dict); !status) return status;
  if (Status status = file->write(data); !status) return status;
  return file->commit();
}

// A file whose header has been read.
struct NpyFile {
  std::string name;
  std::shared_ptr<MappedFile> mapping;
  NpyHeader header;

  const std::byte* data() const { return mapping->bytes().data() + header.size_bytes; }

  static Result<NpyFile> open(const std::filesystem::path& path) {
    Result<std::shared_ptr<MappedFile>> mapping = MappedFile::open(path);
    if (!mapping) return mapping.error();
    Result<NpyHeader> header = parse_header((*mapping)->bytes(), path.string());
    if (!header) return header.error();
    return NpyFile{path.string(), *std::move(mapping), *std::move(header)};
  }
};

// One that holds rays.
struct RaysFile {
  NpyFile npy;
  FloatMatrix matrix;

  std::uint64_t count() const { return npy.header.shape[0]; }

  static Result<RaysFile> open(const std::filesystem::path& path) {
    Result<NpyFile> file = NpyFile::open(path);
    if (!file) return file.error();
    const auto& [name, mapping, header] = *file;
    const std::vector<std::uint64_t>& shape = header.shape;
    if (shape.size() != 2 || (shape[1] != 8 && shape[1] != 6))
      return Error{name + ": rays need shape (N, 8) (org, t_min, dir, t_max) or (N, 6) (org, dir), not " + shape_text(shape)};
    const std::optional<FloatMatrix> matrix = FloatMatrix::make(header, file->data());
    if (!matrix) return Error{name + ": rays need the type float32 or float64, not " + header.descr.substr(0, 80)};
    if (Status status = check_size(header, mapping->bytes().size(), shape[1] * matrix->number_bytes(), name); !status)
      return status.error();
    return RaysFile{*std::move(file), *matrix};
  }
};

}  // namespace

Status write_rays_npy(const std::filesystem::path& path, std::span<const Ray> rays) try {
  return write_npy(path, "'<f4'", {rays.size(), 8}, std::as_bytes(rays));
} catch (const std::bad_alloc&) {
  return out_of_memory("writing a .npy file");
}

Status write_hits_npy(const std::filesystem::path& path, std::span<const Hit> hits) try {
  return write_npy(path, kHitFields, {hits.size()}, std::as_bytes(hits));
} catch (const std::bad_alloc&) {
  return out_of_memory("writing a .npy file");
}

Status write_hits_npy(const std::filesystem::path& path, std::span<const Hit> hits, std::size_t per_ray) try {
  if (per_ray == 0 || hits.size() % per_ray != 0)
    return Error{path.string() + ": " + std::to_string(hits.size()) + " hits are not rays with " + std::to_string(per_ray) +
                 " each"};
  return write_npy(path, kHitFields, {hits.size() / per_ray, per_ray}, std::as_bytes(hits));
} catch (const std::bad_alloc&) {
  return out_of_memory("writing a .npy file");
}

Result<std::uint64_t> count_rays_npy(const std::filesystem::path& path) try {
  const Result<RaysFile> file = RaysFile::open(path);
  return file ? Result<std::uint64_t>(file->count()) : file.error();
} catch (const std::bad_alloc&) {
  return out_of_memory("reading rays");
}

Result<Buffer<Ray>> read_rays_npy(const std::filesystem::path& path) try {
  const Result<RaysFile> file = RaysFile::open(path);
  if (!file) return file.error();
  const bool with_interval = file->npy.header.shape[1] == 8;
  const int dir = with_interval ? 4 : 3;
  const FloatMatrix* const matrix = &file->matrix;
  Buffer<Ray> rays(file->count());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Ray& ray = rays[i] = Ray{};
    ray.org = {matrix->at(i, 0), matrix->at(i, 1), matrix->at(i, 2)};
    ray.dir = {matrix->at(i, dir), matrix->at(i, dir + 1), matrix->at(i, dir + 2)};
    if (with_interval) ray.t_min = matrix->at(i, 3), ray.t_max = matrix->at(i, 7);
  }
  return rays;
} catch (const std::bad_alloc&) {
  return out_of_memory("reading rays");
}

Result<Buffer<Hit>> read_hits_npy(const std::filesystem::path& path) try {
  const Result<NpyFile> file = NpyFile::open(path);
  if (!file) return file.error();
  const auto& [name, mapping, header] = *file;

  if (header.shape.size() != 1) return Error{name + ": hits need shape (N,), not " + shape_text(header.shape)};
  if (header.descr != kHitFields)
    return Error{name + ": hits need the type " + std::string(kHitFields) + ", not " + header.descr.substr(0, 80)};
  if (Status status = check_size(header, mapping->bytes().size(), sizeof(Hit), name); !status) return status.error();

  Buffer<Hit> hits(header.shape[0]);
  if (!hits.empty()) std::memcpy(hits.data(), file->data(), hits.size_bytes());
  return hits;
} catch (const std::bad_alloc&) {
  return out_of_memory("reading hits");
}

}  // namespace accel
