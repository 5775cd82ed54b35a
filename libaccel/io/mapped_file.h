// A regular file as bytes in memory, brought in by the operating system when they are touched.
//
// The mapping is private and copy-on-write: bytes may be changed through a Buffer that borrows them, and the file never is. A
// file that another program shortens while it is mapped ends this one (SIGBUS), as with every mapping; the library's own
// outputs are replaced, never changed in place (io/atomic_file.h).
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

#include "libaccel/core/result.h"

namespace accel {

class MappedFile {
 public:
  // Maps the whole file. Errors: it does not exist, may not be read, or is a folder, a pipe or a device.
  static Result<std::shared_ptr<MappedFile>> open(const std::filesystem::path& path);

  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  std::byte* data() { return data_; }
  std::size_t size() const { return size_; }
  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  MappedFile(std::byte* data, std::size_t size) : data_(data), size_(size) {}

  std::byte* data_;
  std::size_t size_;
};

}  // namespace accel
