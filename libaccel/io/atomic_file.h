// Output that appears whole or not at all: it is written under another name in the same folder, and renamed when it is
// complete.
//
// An output that is destroyed before commit() leaves nothing behind, and what was at the target before stays. A file that is
// replaced keeps its mode; one that must not be written is not replaced. Through a symbolic link the file that it points to is
// replaced, or made. The file that standard output or standard error goes to is refused: what is printed would be lost. A
// target that exists and is not a regular file (/dev/null, a pipe) is
// written directly, since renaming over it would destroy it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "libaccel/core/result.h"

namespace accel {

// A temporary name for writers that open files themselves, such as image libraries. It ends in the target's extension.
class AtomicPath {
 public:
  // Creates an empty file of the temporary name.
  static Result<AtomicPath> create(const std::filesystem::path& target);

  AtomicPath(AtomicPath&& other) noexcept;
  AtomicPath& operator=(AtomicPath&& other) noexcept;
  ~AtomicPath();

  const std::filesystem::path& path() const { return temporary_; }
  const std::filesystem::path& target() const { return target_; }

  // Puts what was written to path() in the target's place.
  Status commit();

 private:
  AtomicPath(std::filesystem::path target, std::filesystem::path temporary);
  void discard() noexcept;

  std::filesystem::path target_;
  std::filesystem::path temporary_;
  bool pending_ = false;  // a temporary file is there to be renamed or removed
};

// A file written front to back.
class AtomicFile {
 public:
  static Result<AtomicFile> create(const std::filesystem::path& target);

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  ~AtomicFile();

  Status write(std::span<const std::byte> bytes);
  Status write(std::string_view text);

  // Closes the file and renames it. With Durable::yes it is on the disk before that.
  enum class Durable : bool { no, yes };
  Status commit(Durable durable = Durable::no);

 private:
  AtomicFile(AtomicPath path, int descriptor);
  void close() noexcept;

  AtomicPath path_;
  int descriptor_ = -1;
};

// All of a file at once.
Status write_file(const std::filesystem::path& target, std::string_view contents);

}  // namespace accel
