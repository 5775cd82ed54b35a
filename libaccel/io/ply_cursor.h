// The body of a PLY file as a sequence of numbers, from text or from binary: one interface for the readers of elements.
//
// A cursor has
//
//   bool number(PlyType, double&)              the next number; false at the end of the line or file, and for other words
//   bool skip(PlyType, std::uint64_t n)        passes over n numbers
//   bool end_item()                            whether an item may end here: in text, at the end of a line, which is passed
//   std::uint64_t room(PlyType) const          how many numbers of a type can follow at most
//   std::uint64_t remaining() const            bytes that follow
//   Error error(item, what) const              names the file, the place and the item
//
// A line of text is an item: all its numbers and nothing else. Blank lines are passed over.
#pragma once

#include <algorithm>
#include <charconv>
#include <span>
#include <string>

#include "libaccel/io/load_bytes.h"
#include "libaccel/io/ply_header.h"

namespace accel {

// A number of any type; double holds them all exactly.
inline double load_number(PlyType type, const std::byte* at, bool swap) {
  switch (type) {
    case PlyType::int8:
      return load<std::int8_t>(at, swap);
    case PlyType::uint8:
      return load<std::uint8_t>(at, swap);
    case PlyType::int16:
      return load<std::int16_t>(at, swap);
    case PlyType::uint16:
      return load<std::uint16_t>(at, swap);
    case PlyType::int32:
      return load<std::int32_t>(at, swap);
    case PlyType::uint32:
      return load<std::uint32_t>(at, swap);
    case PlyType::float32:
      return load<float>(at, swap);
    case PlyType::float64:
      return load<double>(at, swap);
  }
  return 0;
}

class PlyBinaryCursor {
 public:
  PlyBinaryCursor(std::span<const std::byte> bytes, std::size_t offset, bool swap, const std::string& name)
      : bytes_(bytes), offset_(offset), swap_(swap), name_(name) {}

  bool number(PlyType type, double& value) {
    if (room(type) == 0) return false;
    value = load_number(type, here(), swap_);
    offset_ += size_of(type);
    return true;
  }

  bool skip(PlyType type, std::uint64_t n) { return n <= room(type) && skip_bytes(n * size_of(type)); }
  std::uint64_t room(PlyType type) const { return remaining() / size_of(type); }

  bool end_item() { return true; }

  Error error(const std::string& item, const std::string& what) const {
    return Error{name_ + ": " + item + " at byte " + std::to_string(offset_) + ": " + what};
  }

  bool skip_bytes(std::uint64_t n) { return n <= remaining() && (offset_ += n, true); }
  std::uint64_t remaining() const { return bytes_.size() - offset_; }
  const std::byte* here() const { return bytes_.data() + offset_; }
  bool swaps_bytes() const { return swap_; }
  double fraction() const { return static_cast<double>(offset_) / bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
  std::size_t offset_;
  bool swap_;
  const std::string& name_;
};

class PlyAsciiCursor {
 public:
  PlyAsciiCursor(std::span<const std::byte> bytes, std::size_t offset, const std::string& name)
      : begin_(reinterpret_cast<const char*>(bytes.data())), here_(begin_ + offset), end_(begin_ + bytes.size()), name_(name) {
    skip_blank_lines();
  }

  bool number(PlyType type, double& value) {
    skip_blanks();
    const bool has_plus = end_ - here_ > 1 && here_[0] == '+' && here_[1] != '-';
    const char* first = here_ + has_plus;
    // A float is rounded once, from its digits.
    float single = 0;
    std::from_chars_result parsed =
        type == PlyType::float32 ? std::from_chars(first, end_, single) : std::from_chars(first, end_, value);
    if (parsed.ec == std::errc() && type == PlyType::float32) value = single;
    if (parsed.ec == std::errc::result_out_of_range) {
      long double wide = 0;
      parsed = std::from_chars(first, end_, wide);
      value = type == PlyType::float32 ? static_cast<float>(wide) : static_cast<double>(wide);
    }
    if (parsed.ec != std::errc() || (parsed.ptr != end_ && !is_blank(*parsed.ptr) && !is_line_end(*parsed.ptr))) return false;
    here_ = parsed.ptr;
    return true;
  }

  bool skip(PlyType, std::uint64_t n) {
    for (; n > 0; --n) {
      skip_blanks();
      if (at_line_end()) return false;
      while (!at_line_end() && !is_blank(*here_)) ++here_;
    }
    return true;
  }

  bool end_item() {
    skip_blanks();
    if (!at_line_end()) return false;
    skip_blank_lines();
    return true;
  }

  // A digit and a blank each, the last without.
  std::uint64_t room(PlyType) const { return (remaining() + 1) / 2; }

  Error error(const std::string& item, const std::string& what) const {
    return Error{name_ + ":" + std::to_string(1 + std::count(begin_, here_, '\n')) + ": " + item + ": " + what};
  }

  std::uint64_t remaining() const { return static_cast<std::uint64_t>(end_ - here_); }
  double fraction() const { return static_cast<double>(here_ - begin_) / (end_ - begin_); }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t'; }
  static bool is_line_end(char c) { return c == '\n' || c == '\r'; }
  bool at_line_end() const { return here_ == end_ || is_line_end(*here_); }
  void skip_blanks() {
    while (here_ != end_ && is_blank(*here_)) ++here_;
  }
  void skip_blank_lines() {
    while (here_ != end_ && (is_blank(*here_) || is_line_end(*here_))) ++here_;
  }

  const char* begin_;
  const char* here_;
  const char* end_;
  const std::string& name_;
};

}  // namespace accel
