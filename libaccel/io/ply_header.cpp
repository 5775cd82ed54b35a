#include "libaccel/io/ply_header.h"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

namespace accel {
namespace {

constexpr std::pair<std::string_view, PlyType> kTypes[] = {
    {"char", PlyType::int8},     {"int8", PlyType::int8},       {"uchar", PlyType::uint8},    {"uint8", PlyType::uint8},
    {"short", PlyType::int16},   {"int16", PlyType::int16},     {"ushort", PlyType::uint16},  {"uint16", PlyType::uint16},
    {"int", PlyType::int32},     {"int32", PlyType::int32},     {"uint", PlyType::uint32},    {"uint32", PlyType::uint32},
    {"float", PlyType::float32}, {"float32", PlyType::float32}, {"double", PlyType::float64}, {"float64", PlyType::float64},
};

// Headers are short; what is longer is no PLY file.
constexpr std::size_t kLongestLine = 4096;
constexpr std::size_t kMostLines = 10000;

std::optional<PlyType> type_named(std::string_view name) {
  for (const auto& [type_name, type] : kTypes)
    if (type_name == name) return type;
  return std::nullopt;
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.empty()) return words;
    words.push_back(line.substr(0, line.find_first_of(" \t")));
    line.remove_prefix(words.back().size());
  }
}

// A word for a message: short, and without bytes that are no text.
std::string in_quotes(std::string_view word) {
  std::string result = "'";
  for (const char c : word.substr(0, 40)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + "'";
}

class HeaderParser {
 public:
  HeaderParser(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  Result<PlyHeader> parse() {
    const std::optional<std::string_view> magic = next_line();
    if (!magic || split(*magic) != std::vector<std::string_view>{"ply"}) return error("a PLY file begins with the line 'ply'");
    while (header_.lines < kMostLines) {
      const std::optional<std::string_view> line = next_line();
      if (!line) return error("the header has no line 'end_header'");
      const std::vector<std::string_view> words = split(*line);
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") return finish();
      if (Status status = statement(words); !status) return status.error();
    }
    return error("the header is too long");
  }

 private:
  Error error(const std::string& what) const { return Error{name_ + ":" + std::to_string(header_.lines) + ": " + what}; }

  // Without its end (LF, CR LF or CR); none when no line ends before the text or the longest line does.
  std::optional<std::string_view> next_line() {
    const std::string_view rest = text_.substr(header_.size_bytes, kLongestLine);
    ++header_.lines;
    const std::size_t length = rest.find_first_of("\r\n");
    if (length == std::string_view::npos) return std::nullopt;
    // The first line tells how lines end: behind a lone CR, a byte that looks like LF may already be the body's.
    if (header_.lines == 1) ends_in_two_ = rest.substr(length).starts_with("\r\n");
    header_.size_bytes += length + (ends_in_two_ && rest.substr(length).starts_with("\r\n") ? 2 : 1);
    return rest.substr(0, length);
  }

  Status statement(const std::vector<std::string_view>& words) {
    if (words[0] == "format") return format(words);
    if (words[0] == "element") return element(words);
    if (words[0] == "property") return property(words);
    return error(in_quotes(words[0]) + " is not a statement of a PLY header");
  }

  Status format(const std::vector<std::string_view>& words) {
    constexpr std::pair<std::string_view, PlyFormat> kFormats[] = {{"ascii", PlyFormat::ascii},
                                                                   {"binary_little_endian", PlyFormat::little_endian},
                                                                   {"binary_big_endian", PlyFormat::big_endian}};
    if (words.size() != 3 || words[2] != "1.0")
      return error("expected 'format ascii|binary_little_endian|binary_big_endian 1.0'");
    for (const auto& [name, value] : kFormats) {
      if (words[1] != name) continue;
      header_.format = value;
      has_format_ = true;
      return Done{};
    }
    return error(in_quotes(words[1]) + " is not a PLY format");
  }

  Status element(const std::vector<std::string_view>& words) {
    if (words.size() != 3) return error("expected 'element NAME COUNT'");
    PlyElement result{std::string(words[1]), 0, header_.lines, {}};
    const auto [end, status] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), result.count);
    if (status != std::errc() || end != words[2].data() + words[2].size())
      return error(in_quotes(words[2]) + " is not a count");
    if (header_.find(words[1]) != nullptr) return error("a second element " + in_quotes(words[1]));
    header_.elements.push_back(std::move(result));
    return Done{};
  }

  Status property(const std::vector<std::string_view>& words) {
    const bool list = words.size() == 5 && words[1] == "list";
    if (!list && words.size() != 3) return error("expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'");
    if (header_.elements.empty()) return error("a property before the first element");
    PlyProperty result{std::string(words.back()), PlyType::int8, std::nullopt};

    const std::string_view type_name = words[words.size() - 2];
    const std::optional<PlyType> type = type_named(type_name);
    if (!type) return error(in_quotes(type_name) + " is not a PLY type");
    result.type = *type;
    if (list) {
      result.count_type = type_named(words[2]);
      if (!result.count_type) return error(in_quotes(words[2]) + " is not a PLY type");
      if (*result.count_type >= PlyType::float32) return error("a list's length must be an integer");
    }
    if (header_.elements.back().find(result.name) >= 0) return error("a second property " + in_quotes(result.name));
    header_.elements.back().properties.push_back(std::move(result));
    return Done{};
  }

  Result<PlyHeader> finish() {
    if (!has_format_) return error("the header has no line 'format'");
    return std::move(header_);
  }

  std::string_view text_;
  const std::string& name_;
  PlyHeader header_;
  bool has_format_ = false;
  bool ends_in_two_ = false;  // lines end in CR LF
};

}  // namespace

std::size_t size_of(PlyType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

int PlyElement::find(std::string_view first, std::string_view other) const {
  for (std::size_t i = 0; i < properties.size(); ++i)
    if (properties[i].name == first || (!other.empty() && properties[i].name == other)) return static_cast<int>(i);
  return -1;
}

std::size_t PlyElement::least_bytes(PlyFormat format) const {
  // ASCII: a digit and what separates it from the next.
  if (format == PlyFormat::ascii) return 2 * properties.size();
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties) bytes += size_of(property.count_type.value_or(property.type));
  return bytes;
}

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(), [](const PlyProperty& p) { return p.count_type.has_value(); });
}

const PlyElement* PlyHeader::find(std::string_view name) const {
  for (const PlyElement& element : elements)
    if (element.name == name) return &element;
  return nullptr;
}

Result<PlyHeader> parse_ply_header(std::span<const std::byte> bytes, const std::string& name) {
  return HeaderParser({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, name).parse();
}

}  // namespace accel
