#include "libaccel/io/gltf_buffers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include "libaccel/io/load_bytes.h"

namespace accel {
namespace {

// Of numbers, by the names that OpenGL gives them.
enum class Component : std::uint16_t { byte = 5120, unsigned_byte, short_, unsigned_short, unsigned_int = 5125, float_ };

std::size_t size_of(Component component) {
  switch (component) {
    case Component::byte:
    case Component::unsigned_byte:
      return 1;
    case Component::short_:
    case Component::unsigned_short:
      return 2;
    default:
      return 4;
  }
}

Component component_of(const JsonCursor& holder) {
  const JsonCursor type = holder["componentType"];
  const std::uint64_t number = type.natural();
  if (number < 5120 || number > 5126 || number == 5124) type.fail(std::to_string(number) + " is no type of numbers");
  return static_cast<Component>(number);
}

Component unsigned_component_of(const JsonCursor& holder) {
  const Component component = component_of(holder);
  if (component != Component::unsigned_byte && component != Component::unsigned_short && component != Component::unsigned_int)
    holder["componentType"].fail("must be an unsigned integer here");
  return component;
}

// The spec's section 3.11: integers as fractions of the largest, and not below -1.
template <class Integer>
float fraction(Integer value) {
  return std::max(static_cast<float>(value) / static_cast<float>(std::numeric_limits<Integer>::max()), -1.0f);
}

template <class To, class From>
To converted(From value, [[maybe_unused]] bool normalized) {
  if constexpr (std::is_integral_v<From> && sizeof(From) < 4 && std::is_floating_point_v<To>)
    if (normalized) return fraction(value);
  return static_cast<To>(value);
}

// Bytes that a base64 text stands for (RFC 4648).
std::vector<std::byte> decode_base64(const JsonCursor& uri, std::string_view text) {
  static constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::array<std::uint8_t, 256> value_of;
  value_of.fill(0xff);
  for (std::size_t i = 0; i < kDigits.size(); ++i)
    value_of[static_cast<std::uint8_t>(kDigits[i])] = static_cast<std::uint8_t>(i);
  for (int i = 0; i < 2 && text.ends_with('='); ++i) text.remove_suffix(1);

  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t bits = 0, count = 0;
  for (const char c : text) {
    const std::uint8_t value = value_of[static_cast<std::uint8_t>(c)];
    if (value == 0xff) uri.fail("holds a character that is no digit of base64");
    bits = bits << 6 | value, count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> count & 0xffu));
  }
  return bytes;
}

// RFC 3986, section 2.1.
std::string percent_decoded(std::string_view text) {
  const auto digit = [](char c) {
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
  };
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int high = text[i] == '%' && i + 2 < text.size() ? digit(text[i + 1]) : -1, low = high >= 0 ? digit(text[i + 2]) : -1;
    result += low >= 0 ? static_cast<char>(16 * high + low) : text[i];
    i += low >= 0 ? 2 : 0;
  }
  return result;
}

}  // namespace

struct GltfBuffers::Elements {
  Component component;
  std::size_t components, count;
  bool normalized = false;
  const std::byte* first = nullptr;  // null: all are zeros
  std::size_t stride = 0;

  std::size_t size() const { return components * size_of(component); }

  // The elements as numbers of type To.
  template <class To>
  void copy_to(To* to) const {
    const auto copy = [&]<class From>(From) {
      for (std::size_t i = 0; i < count; ++i)
        for (std::size_t k = 0; k < components; ++k)
          *to++ = converted<To>(load<From>(first + i * stride + k * sizeof(From)), normalized);
    };
    switch (component) {
      case Component::byte:
        return copy(std::int8_t{});
      case Component::unsigned_byte:
        return copy(std::uint8_t{});
      case Component::short_:
        return copy(std::int16_t{});
      case Component::unsigned_short:
        return copy(std::uint16_t{});
      case Component::unsigned_int:
        return copy(std::uint32_t{});
      default:
        if constexpr (std::is_floating_point_v<To>) return copy(float{});
    }
  }
};

static_assert(std::endian::native == std::endian::little, "glTF's numbers are read as they lie in the file");

InputBytes GltfBuffers::fetch(const JsonCursor& uri) const {
  const std::string& text = uri.text();
  if (text.starts_with("data:")) {
    const std::size_t comma = text.find(',');
    if (comma == std::string::npos || !std::string_view(text).substr(0, comma).ends_with(";base64"))
      uri.fail("only data URIs in base64 can be read");
    auto bytes = std::make_shared<std::vector<std::byte>>(decode_base64(uri, std::string_view(text).substr(comma + 1)));
    return {*bytes, bytes};
  }
  const std::filesystem::path file = percent_decoded(text);
  if (file.is_absolute() || text.find(':') < text.find('/'))
    uri.fail(uri.quoted() + " is no relative address: others are not followed");
  const Result<InputBytes> input = read_input(folder_ / file, progress_);
  if (!input && input.message() == kInterrupted) throw FormatError{input.message()};
  if (!input) uri.fail(input.message());
  return *input;
}

std::span<const std::byte> GltfBuffers::buffer(std::size_t index) {
  const JsonCursor buffer = document_["buffers"][index];
  fetched_.resize(std::max(fetched_.size(), index + 1));
  if (std::optional<InputBytes>& fetched = fetched_[index]; !fetched) {
    if (const auto uri = buffer.find("uri"))
      fetched = fetch(*uri);
    else if (index == 0 && binary_)
      fetched = InputBytes{*binary_, {}};
    else
      buffer.fail("has no uri, and is not the binary chunk of a .glb");
    if (const std::uint64_t stated = buffer["byteLength"].natural(); stated > fetched->bytes.size())
      buffer.fail("is stated to have " + std::to_string(stated) + " bytes, but there are " +
                  std::to_string(fetched->bytes.size()));
    if (buffer.find("uri")) bytes_ += fetched->bytes.size();
  }
  return fetched_[index]->bytes;
}

// `stride` becomes the view's, where it has one.
std::span<const std::byte> GltfBuffers::view(std::size_t index, std::size_t& stride) {
  const JsonCursor view = document_["bufferViews"][index];
  const std::span<const std::byte> bytes = buffer(view["buffer"].natural_below(document_["buffers"].size()));
  const auto offset = view.find("byteOffset");
  const std::uint64_t first = offset ? offset->natural() : 0, size = view["byteLength"].natural();
  if (first > bytes.size() || size > bytes.size() - first) view.fail("goes beyond the end of its buffer");
  if (const auto given = view.find("byteStride")) stride = given->natural();
  return bytes.subspan(first, size);
}

// Finds where the elements are: `holder` is an accessor or a part of a sparse one, with a view and an offset in it.
void GltfBuffers::place(const JsonCursor& holder, Elements& e) {
  e.stride = e.size();
  const auto bytes = view(holder["bufferView"].natural_below(document_["bufferViews"].size()), e.stride);
  const auto offset = holder.find("byteOffset");
  const std::uint64_t first = offset ? offset->natural() : 0;
  if (e.stride < e.size()) holder.fail("its elements overlap: the view's byteStride is " + std::to_string(e.stride));
  const bool fits =
      first <= bytes.size() && bytes.size() - first >= e.size() && e.count - 1 <= (bytes.size() - first - e.size()) / e.stride;
  if (!fits) holder.fail("goes beyond the end of its view");
  e.first = bytes.data() + first;
}

GltfBuffers::Elements GltfBuffers::elements(const JsonCursor& accessor, std::size_t components) {
  Elements e{component_of(accessor), components, accessor["count"].natural()};
  const std::string type = components == 1 ? "SCALAR" : "VEC" + std::to_string(components);
  if (accessor["type"].text() != type) accessor["type"].fail("must be " + type + " here");
  if (e.count == 0) accessor["count"].fail("must not be 0");
  if (const auto normalized = accessor.find("normalized")) e.normalized = normalized->boolean();
  if (accessor.find("bufferView"))
    place(accessor, e);
  else
    charge(e.count, accessor);
  return e;
}

// With what a sparse accessor replaces: section 3.6.2.3.
template <class T>
std::vector<T> GltfBuffers::numbers(const JsonCursor& accessor, const Elements& e) {
  std::vector<T> result(e.count * e.components);
  if (e.first != nullptr) e.copy_to(result.data());
  const auto sparse = accessor.find("sparse");
  if (!sparse) return result;

  const std::uint64_t count = (*sparse)["count"].natural();
  if (count == 0 || count > e.count) (*sparse)["count"].fail("must be from 1 to the accessor's count");
  const JsonCursor places = (*sparse)["indices"], values = (*sparse)["values"];
  Elements which{unsigned_component_of(places), 1, count}, what = e;
  place(places, which), what.count = count, place(values, what);
  std::vector<std::uint32_t> at(count);
  which.copy_to(at.data());
  std::vector<T> replacements(count * e.components);
  what.copy_to(replacements.data());
  for (std::size_t i = 0; i < count; ++i) {
    if (at[i] >= e.count) places.fail("names element " + std::to_string(at[i]) + " of " + std::to_string(e.count));
    std::copy_n(replacements.begin() + static_cast<std::ptrdiff_t>(i * e.components), e.components,
                result.begin() + static_cast<std::ptrdiff_t>(at[i] * e.components));
  }
  return result;
}

std::vector<float> GltfBuffers::floats(const JsonCursor& accessor, std::size_t components) {
  const Elements e = elements(accessor, components);
  return numbers<float>(accessor, e);
}

std::vector<std::uint32_t> GltfBuffers::indices(const JsonCursor& accessor) {
  const Elements e = elements(accessor, 1);
  unsigned_component_of(accessor);
  return numbers<std::uint32_t>(accessor, e);
}

void GltfBuffers::charge(std::uint64_t count, const JsonCursor& who) {
  if (count > kMostPerByte * bytes_ - std::min(charged_, kMostPerByte * bytes_))
    who.fail("names the same numbers, or zeros, so often that a file of " + std::to_string(bytes_) +
             " bytes would fill the memory");
  charged_ += count;
}

}  // namespace accel
