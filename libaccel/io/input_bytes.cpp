#include "libaccel/io/input_bytes.h"

#include <zstd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <string>
#include <utility>

#include "libaccel/io/mapped_file.h"
#include "libaccel/io/progress_ticker.h"

namespace accel {
namespace {

// Bytes that grow. realloc moves the pages of large blocks instead of copying them.
class GrowingBytes {
 public:
  GrowingBytes() = default;
  GrowingBytes(const GrowingBytes&) = delete;
  GrowingBytes& operator=(const GrowingBytes&) = delete;
  ~GrowingBytes() { std::free(data_); }

  bool reserve(std::size_t capacity) {
    void* grown = std::realloc(data_, capacity);
    if (grown == nullptr) return false;
    data_ = static_cast<std::byte*>(grown);
    capacity_ = capacity;
    return true;
  }

  std::byte* data() { return data_; }
  std::size_t capacity() const { return capacity_; }

  std::shared_ptr<void> release() { return {std::exchange(data_, nullptr), std::free}; }

 private:
  std::byte* data_ = nullptr;
  std::size_t capacity_ = 0;
};

// The first allocation: what the frame says that it holds, but no more than a file of its size is likely to unpack to.
std::size_t first_capacity(std::span<const std::byte> packed) {
  constexpr std::size_t kLeast = 1 << 16;
  const std::size_t likely = std::max(kLeast, packed.size() * 8);
  const unsigned long long stated = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (stated == ZSTD_CONTENTSIZE_UNKNOWN || stated == ZSTD_CONTENTSIZE_ERROR) return likely;
  return std::clamp<unsigned long long>(stated, kLeast, likely);
}

Result<InputBytes> unpack(const std::string& name, std::span<const std::byte> packed, const Progress& progress) {
  const Error too_large{name + ": not enough memory to unpack it"};
  const std::unique_ptr<ZSTD_DStream, size_t (*)(ZSTD_DStream*)> stream(ZSTD_createDStream(), ZSTD_freeDStream);
  GrowingBytes unpacked;
  if (stream == nullptr || !unpacked.reserve(first_capacity(packed))) return too_large;

  // A step of input at a time, so that progress can be told; a file may be several frames, one behind the other.
  constexpr std::size_t kStep = 1 << 20;
  ProgressTicker ticker(progress, "unpack");
  ZSTD_inBuffer in{packed.data(), 0, 0};
  std::size_t size = 0, wanted = 1;
  while (in.pos < packed.size() || wanted != 0) {
    if (size == unpacked.capacity() && !unpacked.reserve(unpacked.capacity() * 2)) return too_large;
    in.size = std::min(packed.size(), in.pos + kStep);
    ZSTD_outBuffer out{unpacked.data(), unpacked.capacity(), size};
    wanted = ZSTD_decompressStream(stream.get(), &out, &in);
    if (ZSTD_isError(wanted))
      return Error{name + ": damaged zstd data near byte " + std::to_string(in.pos) + " (" + ZSTD_getErrorName(wanted) + ")"};
    const bool stuck = in.pos == packed.size() && out.pos == size;
    size = out.pos;
    if (wanted != 0 && stuck) return Error{name + ": the zstd data ends early: the file is truncated"};
    if (!ticker.tick(static_cast<double>(in.pos) / packed.size())) return Error{std::string(kInterrupted)};
  }
  std::byte* data = unpacked.data();
  return InputBytes{{data, size}, unpacked.release()};
}

}  // namespace

bool is_zstd_name(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".zst";
}

Result<InputBytes> read_input(const std::filesystem::path& path, const Progress& progress) {
  Result<std::shared_ptr<MappedFile>> file = MappedFile::open(path);
  if (!file) return file.error();
  if (is_zstd_name(path)) return unpack(path.string(), (*file)->bytes(), progress);
  const std::span<const std::byte> bytes = (*file)->bytes();
  return InputBytes{bytes, *std::move(file)};
}

}  // namespace accel
