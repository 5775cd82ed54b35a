// A JSON document for readers of large schemas: a cursor knows the way to its value, so that mistakes can be named.
//
// What is missing, of another type or out of range is a FormatError, an exception: every other line would be a check otherwise.
// Readers catch it, and return its message as an Error; it never leaves the library.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libaccel/core/result.h"

namespace accel {

struct FormatError {
  std::string message;
};

// Errors name the file and the line.
Result<nlohmann::json> parse_json(std::string_view text, const std::string& name);

class JsonCursor {
 public:
  // The document must outlive its cursors.
  explicit JsonCursor(const nlohmann::json& document) : value_(&document) {}

  // A member of an object. Where it is optional, none if it is not there.
  JsonCursor operator[](std::string_view key) const;
  std::optional<JsonCursor> find(std::string_view key) const;

  // A list.
  std::size_t size() const;
  JsonCursor operator[](std::size_t i) const;
  std::vector<double> numbers(std::size_t count) const;

  double number() const;
  std::uint64_t natural() const;                           // at most 2^53, as JSON's numbers are doubles for many writers
  std::uint64_t natural_below(std::uint64_t bound) const;  // an index: of a list, for one
  const std::string& text() const;
  std::string quoted() const;  // the text's beginning in quotes, printable: for messages
  bool boolean() const;

  // Behind the way to the value, as in "nodes[3].mesh: ...".
  [[noreturn]] void fail(const std::string& what) const;

 private:
  JsonCursor(const nlohmann::json& value, std::string path) : value_(&value), path_(std::move(path)) {}
  const nlohmann::json& object() const;

  const nlohmann::json* value_;
  std::string path_;  // empty for the document
};

}  // namespace accel
