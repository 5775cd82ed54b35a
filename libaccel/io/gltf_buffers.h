// The numbers of a glTF file: accessors, which look at views of buffers (glTF 2.0, sections 3.6 and 4.4).
//
// A buffer is read when something in it is asked for, so that textures, animations and skins are never touched. It is the
// binary chunk of a .glb, a data URI, or a file named relative to the scene's folder, mapped. Elements may lie interleaved;
// sparse accessors are resolved; integers are converted, and divided where they are normalised (KHR_mesh_quantization).
//
// Every range is compared with what there is before anything is allocated. What costs no bytes, zeros of accessors without a
// view, and what can be named again and again, is charged to the bytes of the file. Mistakes are FormatErrors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "libaccel/io/input_bytes.h"
#include "libaccel/io/json_cursor.h"

namespace accel {

inline constexpr std::uint64_t kMostPerByte = 16;

class GltfBuffers {
 public:
  // `bytes` is the size of the file, `binary` a .glb's binary chunk, if there is one; `folder` is where other files are.
  GltfBuffers(const JsonCursor& document, std::uint64_t bytes, std::optional<std::span<const std::byte>> binary,
              std::filesystem::path folder, const Progress& progress)
      : document_(document), bytes_(bytes), binary_(binary), folder_(std::move(folder)), progress_(progress) {}

  // An accessor's elements, of so many numbers each (3 or 4), one after the other.
  std::vector<float> floats(const JsonCursor& accessor, std::size_t components);
  // An accessor's elements, which are single numbers.
  std::vector<std::uint32_t> indices(const JsonCursor& accessor);

  // Charges so many things to the bytes that have been read; fails for `who` where these are too few.
  void charge(std::uint64_t count, const JsonCursor& who);

 private:
  struct Elements;
  Elements elements(const JsonCursor& accessor, std::size_t components);
  void place(const JsonCursor& holder, Elements& e);
  template <class T>
  std::vector<T> numbers(const JsonCursor& accessor, const Elements& e);
  std::span<const std::byte> view(std::size_t index, std::size_t& stride);
  std::span<const std::byte> buffer(std::size_t index);
  InputBytes fetch(const JsonCursor& uri) const;

  JsonCursor document_;
  std::uint64_t bytes_, charged_ = 0;
  std::optional<std::span<const std::byte>> binary_;
  std::filesystem::path folder_;
  const Progress& progress_;
  std::vector<std::optional<InputBytes>> fetched_;  // by buffer
};

}  // namespace accel
