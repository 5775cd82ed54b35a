// What the fuzz targets share: their inputs as bytes, as files and as numbers, and how a target says that something is wrong.
//
// A target is one file with a function LLVMFuzzerTestOneInput. It is linked with libFuzzer where the compiler has it (the
// preset `fuzz`), and with replay_main.cpp everywhere else. README.md says how they are run.
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace accel::fuzz {

using Input = std::span<const std::uint8_t>;

inline std::span<const std::byte> bytes_of(Input input) { return std::as_bytes(input); }
inline std::string_view text_of(Input input) { return {reinterpret_cast<const char*>(input.data()), input.size()}; }

// Ends the program if something that must hold does not.
inline void require(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: %s\n", what.c_str());
  std::abort();
}

// The input as a file, for readers that map files. One file a process and ending, overwritten by the next input.
class InputFile {
 public:
  explicit InputFile(std::string_view ending)
      : path_(std::filesystem::temp_directory_path() / ("accel-fuzz-" + std::to_string(::getpid()) + std::string(ending))) {}
  ~InputFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::filesystem::path& holding(Input input) const {
    std::ofstream out(path_, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
    out.close();
    require(out.good(), "the input cannot be written to " + path_.string());
    return path_;
  }

 private:
  std::filesystem::path path_;
};

// Takes numbers from the front of an input; zeros when it has ended.
class NumberReader {
 public:
  explicit NumberReader(Input input) : left_(input) {}

  bool empty() const { return left_.empty(); }

  template <class T>
  T next() {
    T value{};
    const std::size_t size = left_.size() < sizeof(T) ? left_.size() : sizeof(T);
    if (size > 0) std::memcpy(&value, left_.data(), size);
    left_ = left_.subspan(size);
    return value;
  }

 private:
  Input left_;
};

}  // namespace accel::fuzz
