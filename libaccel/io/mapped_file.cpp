#include "libaccel/io/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "libaccel/core/out_of_memory.h"
#include "libaccel/io/system_error.h"

namespace accel {
namespace {

// Closes a descriptor when it leaves the scope; a mapping outlives it.
struct Descriptor {
  int value;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

}  // namespace

Result<std::shared_ptr<MappedFile>> MappedFile::open(const std::filesystem::path& path) try {
  // O_NONBLOCK: opening a pipe without a writer must not wait.
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (file.value < 0) return system_error(path, "cannot open", errno);

  struct stat status;
  if (::fstat(file.value, &status) != 0) return system_error(path, "cannot read", errno);
  if (S_ISDIR(status.st_mode)) return Error{path.string() + ": is a folder"};
  if (!S_ISREG(status.st_mode)) return Error{path.string() + ": is not a regular file"};

  // There are no empty mappings. The owner is there before what it owns: making it may fail.
  std::shared_ptr<MappedFile> mapped(new MappedFile(nullptr, 0));
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) return mapped;
  void* data = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_NORESERVE, file.value, 0);
  if (data == MAP_FAILED) return system_error(path, "cannot map into memory", errno);
  mapped->data_ = static_cast<std::byte*>(data);
  mapped->size_ = size;
  return mapped;
} catch (const std::bad_alloc&) {
  return out_of_memory("opening a file");
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(data_, size_);
}

}  // namespace accel
