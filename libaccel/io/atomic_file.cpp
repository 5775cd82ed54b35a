#include "libaccel/io/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <string>
#include <utility>

#include "libaccel/core/out_of_memory.h"
#include "libaccel/io/system_error.h"

namespace accel {
namespace {

namespace fs = std::filesystem;

// A name beside `target`: hidden, unlikely to be taken, and with the target's extension, by which image
// libraries choose the format.
fs::path temporary_name(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  const auto ticks = std::chrono::steady_clock::now().time_since_epoch().count();
  const std::string unique = std::to_string(::getpid()) + "-" + std::to_string(ticks % 1'000'000'000) + "-" +
                             std::to_string(counter.fetch_add(1, std::memory_order_relaxed));
  return target.parent_path() / ("." + target.stem().string().substr(0, 100) + ".tmp-" + unique + target.extension().string());
}

// Whether a file is where what the program prints goes: /dev/stdout, where that is a file, is a link to it.
bool is_printed_to(const fs::path& path) {
  struct stat file, printed;
  if (::stat(path.c_str(), &file) != 0) return false;
  for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO})
    if (::fstat(descriptor, &printed) == 0 && file.st_dev == printed.st_dev && file.st_ino == printed.st_ino) return true;
  return false;
}

// Creates a file that was not there, with the mode that the user's mask gives. Returns a descriptor, or -1 and errno.
int create_new(const fs::path& path) { return ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666); }

}  // namespace

AtomicPath::AtomicPath(fs::path target, fs::path temporary)
    : target_(std::move(target)), temporary_(std::move(temporary)), pending_(temporary_ != target_) {}

AtomicPath::AtomicPath(AtomicPath&& other) noexcept
    : target_(std::move(other.target_)),
      temporary_(std::move(other.temporary_)),
      pending_(std::exchange(other.pending_, false)) {}

AtomicPath& AtomicPath::operator=(AtomicPath&& other) noexcept {
  if (this == &other) return *this;
  discard();
  target_ = std::move(other.target_);
  temporary_ = std::move(other.temporary_);
  pending_ = std::exchange(other.pending_, false);
  return *this;
}

AtomicPath::~AtomicPath() { discard(); }

void AtomicPath::discard() noexcept {
  if (std::exchange(pending_, false)) ::unlink(temporary_.c_str());
}

Result<AtomicPath> AtomicPath::create(const fs::path& named) try {
  std::error_code ignored;
  fs::path target = named;
  constexpr int kMostLinks = 40;
  if (fs::is_symlink(fs::symlink_status(target, ignored)) && fs::exists(target, ignored)) {
    target = fs::canonical(target, ignored);
  } else {
    for (int i = 0; i < kMostLinks && fs::is_symlink(fs::symlink_status(target, ignored)); ++i)
      target = target.parent_path() / fs::read_symlink(target, ignored);
  }
  if (target.empty()) target = named;

  const fs::file_status status = fs::status(target, ignored);
  if (fs::is_directory(status)) return Error{named.string() + ": is a folder"};
  if (fs::exists(status) && !fs::is_regular_file(status)) return AtomicPath(target, target);
  if (is_printed_to(target)) return Error{named.string() + ": is the file that this program prints to; give another name"};
  // Renaming would replace a file that its owner has protected.
  if (fs::exists(status) && ::access(target.c_str(), W_OK) != 0) return system_error(named, "cannot be replaced", errno);

  constexpr int kAttempts = 16;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    fs::path temporary = temporary_name(target);
    if (const int descriptor = create_new(temporary); descriptor >= 0) {
      // Some file systems have no modes: then there is nothing to keep.
      if (fs::exists(status)) (void)::fchmod(descriptor, static_cast<mode_t>(status.permissions()));
      ::close(descriptor);
      // Moved, since a copy may fail, and then nobody would remove the file.
      return AtomicPath(std::move(target), std::move(temporary));
    }
    if (errno != EEXIST) break;
  }
  return system_error(named, "cannot write here", errno);
} catch (const std::bad_alloc&) {
  return out_of_memory("creating a file");
}

Status AtomicPath::commit() try {
  if (!pending_) return Done{};
  if (std::rename(temporary_.c_str(), target_.c_str()) != 0) {
    const int error_number = errno;
    discard();
    return system_error(target_, "cannot be replaced", error_number);
  }
  pending_ = false;
  return Done{};
} catch (const std::bad_alloc&) {
  return out_of_memory("replacing a file");
}

AtomicFile::AtomicFile(AtomicPath path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
  if (this == &other) return *this;
  close();
  path_ = std::move(other.path_);
  descriptor_ = std::exchange(other.descriptor_, -1);
  return *this;
}

AtomicFile::~AtomicFile() { close(); }

void AtomicFile::close() noexcept {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
}

Result<AtomicFile> AtomicFile::create(const fs::path& target) try {
  Result<AtomicPath> path = AtomicPath::create(target);
  if (!path) return path.error();
  const int descriptor = ::open(path->path().c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return system_error(target, "cannot write", errno);
  return AtomicFile(*std::move(path), descriptor);
} catch (const std::bad_alloc&) {
  return out_of_memory("creating a file");
}

Status AtomicFile::write(std::span<const std::byte> bytes) try {
  // Linux writes 2 GiB at most in one call.
  constexpr std::size_t kLargestWrite = std::size_t{1} << 30;
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), std::min(bytes.size(), kLargestWrite));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return system_error(path_.target(), "cannot write", errno);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return Done{};
} catch (const std::bad_alloc&) {
  return out_of_memory("writing a file");
}

Status AtomicFile::write(std::string_view text) { return write(std::as_bytes(std::span(text))); }

Status AtomicFile::commit(Durable durable) try {
  if (durable == Durable::yes && ::fsync(descriptor_) != 0) return system_error(path_.target(), "cannot write", errno);
  // A full disk or a lost server may be reported only here.
  if (::close(std::exchange(descriptor_, -1)) != 0) return system_error(path_.target(), "cannot write", errno);
  return path_.commit();
} catch (const std::bad_alloc&) {
  return out_of_memory("writing a file");
}

Status write_file(const fs::path& target, std::string_view contents) try {
  Result<AtomicFile> file = AtomicFile::create(target);
  if (!file) return file.error();
  if (Status written = file->write(contents); !written) return written;
  return file->commit();
} catch (const std::bad_alloc&) {
  return out_of_memory("writing a file");
}

}  // namespace accel
