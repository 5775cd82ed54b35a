// The container of structure files (.accel): named arrays behind a table, checksummed, aligned, memory-mapped.
//
// Layout, all of it in the byte order of the writer, which the header tells:
//
//   header    64 bytes: magic, version, byte-order mark, file size, number of sections, checksums of the table and the header
//   table     64 bytes each: name (23 characters at most), offset, size in bytes, element size, checksum
//   sections  in the table's order, each at the next multiple of kBufferAlignment bytes, padded with zeros to the next
//
// Checksums are XXH3-64. A section's covers its padding too, so that no byte of a file is unprotected. Opening reads header and
// table only; a section is verified when it is first taken and its pages are not touched before. Arrays borrow the mapping.
//
// The container knows nothing of what the arrays mean: see io/structure_sections.h. Errors name the file and the section; no
// file, whatever its bytes, causes anything else.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libaccel/core/buffer.h"
#include "libaccel/core/result.h"

namespace accel {

inline constexpr std::uint32_t kAccelFileVersion = 4;

// Without them nothing protects a file from changes that leave it well formed. What is read is validated all the same, so that
// nothing worse than wrong hits comes of it; fuzzers rely on this.
enum class VerifyChecksums : bool { no, yes };

class AccelFile {
 public:
  static Result<AccelFile> open(const std::filesystem::path& path, VerifyChecksums verify = VerifyChecksums::yes);

  const std::filesystem::path& path() const;
  std::uint64_t size_bytes() const;
  std::vector<std::string> section_names() const;
  bool has(std::string_view name) const;

  // The number of elements of a section, without touching it; 0 where there is no such section.
  std::uint64_t count(std::string_view name) const;

  // A section as an array that shares the mapping. Errors: no such section, elements of another size, checksum mismatch.
  template <class T>
  Result<Buffer<T>> array(std::string_view name) const {
    Result<RawSection> raw = take(name, sizeof(T));
    if (!raw) return raw.error();
    return Buffer<T>(reinterpret_cast<T*>(raw->data), raw->size_bytes / sizeof(T), std::move(raw->keep_alive));
  }

  // A section of one element.
  template <class T>
  Result<T> value(std::string_view name) const {
    Result<Buffer<T>> values = array<T>(name);
    if (!values) return values.error();
    if (values->size() != 1) return error(name, "has " + std::to_string(values->size()) + " elements instead of one");
    return (*values)[0];
  }

  // A section of characters.
  Result<std::string> text(std::string_view name) const;

  // An error about a section (or about the whole file, with an empty name), for readers that validate what they take.
  Error error(std::string_view section, std::string_view what) const;

 private:
  struct State;
  struct RawSection {
    std::byte* data;
    std::uint64_t size_bytes;
    std::shared_ptr<void> keep_alive;
  };
  explicit AccelFile(std::shared_ptr<State> state) : state_(std::move(state)) {}
  Result<RawSection> take(std::string_view name, std::size_t element_size) const;

  std::shared_ptr<State> state_;
};

// Where there is no memory for a section that is added, write() says so.
class AccelFileWriter {
 public:
  // Adds an array, which must stay as it is until write(). Names are unique.
  template <class T>
  void add(std::string_view name, std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kBufferAlignment);
    add_borrowed(name, std::as_bytes(values), sizeof(T));
  }
  template <class T>
  void add(std::string_view name, const Buffer<T>& values) {
    add(name, values.span());
  }

  // Adds a copy of an array.
  template <class T>
  void add_copy(std::string_view name, std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kBufferAlignment);
    add_copied(name, std::as_bytes(values), sizeof(T));
  }

  // Adds one element or a text, of which a copy is kept.
  template <class T>
  void add_value(std::string_view name, const T& value) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kBufferAlignment);
    add_copied(name, std::as_bytes(std::span<const T>(&value, 1)), sizeof(T));
  }
  void add_text(std::string_view name, std::string_view text) { add_copied(name, std::as_bytes(std::span(text)), 1); }

  // Writes the file, whole or not at all.
  Status write(const std::filesystem::path& path) const;

 private:
  struct Section {
    std::string name;
    std::span<const std::byte> bytes;
    std::uint32_t element_size;
    std::shared_ptr<std::vector<std::byte>> copy;  // what bytes refers to, where the writer keeps it
  };
  void add_borrowed(std::string_view name, std::span<const std::byte> bytes, std::size_t element_size);
  void add_copied(std::string_view name, std::span<const std::byte> bytes, std::size_t element_size);

  std::vector<Section> sections_;
  bool complete_ = true;  // no section was lost
};

}  // namespace accel
