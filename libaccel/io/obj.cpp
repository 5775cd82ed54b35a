#include "libaccel/io/obj.h"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <istream>
#include <optional>
#include <streambuf>
#include <string_view>

#include "libaccel/io/face_list.h"
#include "libaccel/io/progress_ticker.h"

namespace accel {
namespace {

bool is_line_end(char c) { return c == '\n' || c == '\r'; }

// A text as a stream that can be asked where it is, and ended early.
class TextStream : public std::streambuf {
 public:
  explicit TextStream(std::string_view text) {
    // The base class wants pointers to non-const; nothing is written through them.
    char* begin = const_cast<char*>(text.data());
    begin_ = begin, end_ = begin + text.size();
    setg(begin, begin, begin + text.size());
  }

  // No more is read.
  void stop() {
    stopped_at_ = gptr();
    setg(egptr(), egptr(), egptr());
  }

  double fraction() const { return static_cast<double>(gptr() - begin_) / (end_ - begin_); }

  // The line that was read last, without its end.
  std::string_view line() const {
    const char* last = line_end();
    const char* first = last;
    while (first > begin_ && !is_line_end(first[-1])) --first;
    return {first, static_cast<std::size_t>(last - first)};
  }

  // Where it ends.
  std::size_t line_end_offset() const { return static_cast<std::size_t>(line_end() - begin_); }

 private:
  const char* line_end() const {
    const char* last = stopped_at_ != nullptr ? stopped_at_ : gptr();
    if (last > begin_ && last[-1] == '\n') --last;
    if (last > begin_ && last[-1] == '\r') --last;
    return last;
  }

  const char* begin_;
  const char* end_;
  const char* stopped_at_ = nullptr;
};

// The number, counted from 1, of the line that ends at an offset.
std::size_t line_number(std::string_view text, std::size_t line_end_offset) {
  std::size_t number = 1;
  for (std::size_t i = 0; i < line_end_offset; ++i)
    number += text[i] == '\n' || (text[i] == '\r' && !text.substr(i).starts_with("\r\n"));
  return number;
}

// The next word of a line; empty at the end or at a comment.
std::string_view next_word(std::string_view& line) {
  const std::size_t first = std::min(line.find_first_not_of(" \t"), line.size());
  line.remove_prefix(first);
  if (line.starts_with('#')) return {};
  const std::string_view word = line.substr(0, line.find_first_of(" \t"));
  line.remove_prefix(word.size());
  return word;
}

// Whether the word is digits, with or without a sign, and does not overflow.
bool is_index(std::string_view word) {
  if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
  return !word.empty() && word.size() <= 9 && word.find_first_not_of("0123456789") == std::string_view::npos;
}

// Whether the word is up to three indices between slashes, of which the first must be there.
bool is_corner(std::string_view word) {
  for (int part = 0; part < 3; ++part) {
    const std::string_view index = word.substr(0, word.find('/'));
    if (!is_index(index) && (part == 0 || !index.empty())) return false;
    if (index.size() == word.size()) return true;
    word.remove_prefix(index.size() + 1);
  }
  return false;
}

// Where the first line ends that is the letter v and nothing else, which tinyobjloader passes over; npos if there is none.
std::size_t end_of_lone_v(std::string_view text) {
  for (std::size_t v = text.find('v'); v != std::string_view::npos; v = text.find('v', v + 1)) {
    if (v + 1 < text.size() && !is_line_end(text[v + 1])) continue;
    const std::size_t before = text.substr(0, v).find_last_not_of(" \t");
    if (before == std::string_view::npos || is_line_end(text[before])) return v + 1;
  }
  return std::string_view::npos;
}

std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  return text.substr(text.starts_with(kMark) ? kMark.size() : 0);
}

// The text with blanks for what continues a line: a backslash at its end, but for comments, and that end. Empty where no line
// is continued.
std::string with_joined_lines(std::string_view text) {
  std::string joined;
  if (text.find('\\') == std::string_view::npos) return joined;
  bool is_comment = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    is_comment = text[i] == '#' || (is_comment && !is_line_end(text[i]));
    if (is_comment || text[i] != '\\') continue;
    const std::string_view rest = text.substr(i + 1);
    const std::size_t line_end = rest.starts_with("\r\n") ? 2 : !rest.empty() && is_line_end(rest[0]) ? 1 : 0;
    if (line_end == 0) continue;
    if (joined.empty()) joined = text;
    std::fill_n(joined.begin() + static_cast<std::ptrdiff_t>(i), 1 + line_end, ' ');
    i += line_end;
  }
  return joined;
}

class ObjReader {
 public:
  ObjReader(std::string_view text, const std::string& name, const LoadOptions& options)
      : text_(text),
        joined_(with_joined_lines(text)),
        stream_(joined_.empty() ? text : joined_),
        name_(name),
        options_(options),
        ticker_(options.progress, "read") {}

  Result<TriangleMesh> read();

 private:
  void vertex(std::array<float, 3> position);
  void face(std::span<const tinyobj::index_t> corners);
  std::optional<float> coordinate(float parsed, std::string_view word);
  void check_for_stop();
  void fail(const std::string& what);

  const std::string_view text_;
  const std::string joined_;  // see with_joined_lines(): offsets are those of the text
  TextStream stream_;
  const std::string& name_;
  const LoadOptions& options_;
  ProgressTicker ticker_;
  std::vector<Vec3> vertices_;
  FaceList faces_;
  std::vector<std::uint32_t> corners_;  // of one face
  std::uint32_t largest_ = 0;           // the largest vertex number that a face names before that vertex was read…
  std::size_t largest_at_ = 0;          // …and where the line of that face ends
  bool has_faces_ = false;
  std::size_t lines_ = 0;
  std::optional<Error> error_;
};

void ObjReader::fail(const std::string& what) {
  if (error_) return;
  error_ = Error{name_ + ":" + std::to_string(line_number(text_, stream_.line_end_offset())) + ": " + what};
  stream_.stop();
}

void ObjReader::check_for_stop() {
  constexpr std::size_t kLinesBetweenTicks = 4096;
  if (++lines_ % kLinesBetweenTicks != 0 || ticker_.tick(stream_.fraction())) return;
  error_ = Error{std::string(kInterrupted)};
  stream_.stop();
}

// tinyobjloader reads 0 where there is no number, and stops at the first character that does not belong to one. What it read
// serves for numbers that are too large or too small for a float.
std::optional<float> ObjReader::coordinate(float parsed, std::string_view word) {
  float value = 0;
  const char* end = word.data() + word.size();
  const bool has_plus = word.starts_with('+') && !word.starts_with("+-");
  const auto [rest, status] = std::from_chars(word.data() + has_plus, end, value);
  if (rest == end && status == std::errc::result_out_of_range) return parsed;
  if (rest == end && status == std::errc()) return value;
  fail(word.empty() ? "a vertex needs three numbers" : "'" + std::string(word.substr(0, 40)) + "' is not a number");
  return std::nullopt;
}

void ObjReader::vertex(std::array<float, 3> position) {
  if (error_) return;
  std::string_view line = stream_.line();
  next_word(line);
  for (float& value : position) {
    const std::optional<float> checked = coordinate(value, next_word(line));
    if (!checked) return;
    value = *checked;
  }
  vertices_.push_back({position[0], position[1], position[2]});
  check_for_stop();
}

void ObjReader::face(std::span<const tinyobj::index_t> corners) {
  if (error_) return;
  std::string_view line = stream_.line();
  next_word(line);
  corners_.clear();
  for (const tinyobj::index_t& corner : corners) {
    const std::string_view word = next_word(line);
    if (word.empty()) break;
    if (!is_corner(word)) return fail("'" + std::string(word.substr(0, 40)) + "' is not a face's corner");

    const auto count = static_cast<std::int64_t>(vertices_.size());
    const std::int64_t number = corner.vertex_index < 0 ? count + corner.vertex_index + 1 : corner.vertex_index;
    if (number < 1)
      return fail("a face names vertex " + std::to_string(corner.vertex_index) + " of " + std::to_string(count) +
                  " (vertices are counted from 1, or back from -1)");
    if (number > count && number > largest_) {
      largest_ = static_cast<std::uint32_t>(number);
      largest_at_ = stream_.line_end_offset();
    }
    corners_.push_back(static_cast<std::uint32_t>(number - 1));
  }
  has_faces_ = true;
  faces_.add(corners_);
  check_for_stop();
}

Result<TriangleMesh> ObjReader::read() {
  tinyobj::callback_t callbacks;
  callbacks.vertex_cb = [](void* self, float x, float y, float z, float) { static_cast<ObjReader*>(self)->vertex({x, y, z}); };
  callbacks.index_cb = [](void* self, tinyobj::index_t* corners, int count) {
    static_cast<ObjReader*>(self)->face({corners, static_cast<std::size_t>(count)});
  };
  std::istream input(&stream_);
  tinyobj::LoadObjWithCallback(input, callbacks, this);
  if (error_) return *error_;

  if (const std::size_t end = end_of_lone_v(joined_.empty() ? text_ : joined_); end != std::string_view::npos)
    return Error{name_ + ":" + std::to_string(line_number(text_, end)) + ": a vertex needs three numbers"};
  if (largest_ > vertices_.size())
    return Error{name_ + ":" + std::to_string(line_number(text_, largest_at_)) + ": a face names vertex " +
                 std::to_string(largest_) + ", but the file has " + std::to_string(vertices_.size())};
  if (vertices_.empty() && !has_faces_) return Error{name_ + ": has neither vertices nor faces; is it an OBJ file?"};

  TriangleMesh mesh;
  mesh.vertices = Buffer<Vec3>::copy_of(vertices_);
  Result<Buffer<IndexTriple>> triangles = faces_.triangulate({}, vertices_, name_);
  if (!triangles) return triangles.error();
  mesh.triangles = *std::move(triangles);
  if (options_.skipped_faces != nullptr) *options_.skipped_faces += faces_.skipped();
  return mesh;
}

}  // namespace

Result<TriangleMesh> parse_obj(std::span<const std::byte> bytes, const std::string& name, const LoadOptions& options) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return ObjReader(without_byte_order_mark(text), name, options).read();
}

}  // namespace accel
