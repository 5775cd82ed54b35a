// The header of a PLY file: which elements follow it, and how their properties are stored.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "libaccel/core/result.h"

namespace accel {

enum class PlyFormat : std::uint8_t { ascii, little_endian, big_endian };
enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type;                       // of the value, or of a list's items
  std::optional<PlyType> count_type;  // of a list's length; none: not a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::size_t line = 0;  // of the header, for messages
  std::vector<PlyProperty> properties;

  // The index of a property of any of two names, or -1.
  int find(std::string_view name, std::string_view other = {}) const;

  // The fewest bytes that one item can take, and whether all take exactly that.
  std::size_t least_bytes(PlyFormat format) const;
  bool has_lists() const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::size_t size_bytes = 0;  // the body begins here
  std::size_t lines = 0;

  const PlyElement* find(std::string_view name) const;
  bool swaps_bytes() const {
    return format != (std::endian::native == std::endian::little ? PlyFormat::little_endian : PlyFormat::big_endian);
  }
};

// Errors name the line.
Result<PlyHeader> parse_ply_header(std::span<const std::byte> bytes, const std::string& name);

}  // namespace accel
