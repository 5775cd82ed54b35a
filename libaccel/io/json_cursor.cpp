#include "libaccel/io/json_cursor.h"

#include <algorithm>

namespace accel {

using Json = nlohmann::json;

Result<Json> parse_json(std::string_view text, const std::string& name) {
  Json document = Json::parse(text, nullptr, false);
  if (!document.is_discarded()) return document;
  // Only the throwing parser says where the mistake is.
  std::size_t at = 0;
  try {
    [[maybe_unused]] const Json parsed = Json::parse(text);
  } catch (const Json::parse_error& error) {
    at = std::min(error.byte, text.size());
  } catch (const Json::exception&) {
    return Error{name + ": holds a number that is too large"};
  }
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  return Error{name + ":" + std::to_string(line) + ": is not valid JSON"};
}

void JsonCursor::fail(const std::string& what) const { throw FormatError{path_.empty() ? what : path_ + ": " + what}; }

const Json& JsonCursor::object() const {
  if (!value_->is_object()) fail("must be an object in braces");
  return *value_;
}

std::optional<JsonCursor> JsonCursor::find(std::string_view key) const {
  const auto found = object().find(key);
  if (found == object().end()) return std::nullopt;
  return JsonCursor(*found, (path_.empty() ? "" : path_ + ".") + std::string(key));
}

JsonCursor JsonCursor::operator[](std::string_view key) const {
  const std::optional<JsonCursor> found = find(key);
  if (!found) fail(std::string(key) + " is missing");
  return *found;
}

std::size_t JsonCursor::size() const {
  if (!value_->is_array()) fail("must be a list in brackets");
  return value_->size();
}

JsonCursor JsonCursor::operator[](std::size_t i) const {
  if (i >= size()) fail("has " + std::to_string(size()) + " elements, and number " + std::to_string(i) + " is asked for");
  return {(*value_)[i], path_ + "[" + std::to_string(i) + "]"};
}

std::vector<double> JsonCursor::numbers(std::size_t count) const {
  if (size() != count) fail("must be " + std::to_string(count) + " numbers in brackets");
  std::vector<double> result;
  for (std::size_t i = 0; i < count; ++i) result.push_back((*this)[i].number());
  return result;
}

double JsonCursor::number() const {
  if (!value_->is_number()) fail("must be a number");
  return value_->get<double>();
}

std::uint64_t JsonCursor::natural() const {
  constexpr double kLargest = 0x1p53;
  const double value = number();
  if (!(value >= 0 && value <= kLargest) || value != static_cast<double>(static_cast<std::uint64_t>(value)))
    fail("must be a number without a fraction, and not negative");
  return static_cast<std::uint64_t>(value);
}

std::uint64_t JsonCursor::natural_below(std::uint64_t bound) const {
  const std::uint64_t value = natural();
  if (value >= bound) fail("is " + std::to_string(value) + ", but there are " + std::to_string(bound));
  return value;
}

const std::string& JsonCursor::text() const {
  if (!value_->is_string()) fail("must be a string");
  return value_->get_ref<const std::string&>();
}

std::string JsonCursor::quoted() const {
  constexpr std::size_t kMost = 60;
  std::string beginning = text().substr(0, kMost);
  for (char& c : beginning) c = c >= ' ' && c <= '~' ? c : '?';
  return "'" + beginning + (text().size() > kMost ? "..." : "") + "'";
}

bool JsonCursor::boolean() const {
  if (!value_->is_boolean()) fail("must be true or false");
  return value_->get<bool>();
}

}  // namespace accel
