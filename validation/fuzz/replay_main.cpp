// Runs a fuzz target over files, and over the files in folders, that the command line names: what libFuzzer does with the same
// arguments, for compilers without it. Fails if there was no file.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "validation/fuzz/fuzz_input.h"

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_in(const fs::path& path) {
  if (!fs::is_directory(path)) return {path};
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path))
    if (entry.is_regular_file()) files.push_back(entry.path());
  return files;
}

// Into memory of exactly its size, so that reading behind its end is seen.
void replay(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::vector<char> read{std::istreambuf_iterator<char>(in), {}};
  const std::vector<std::uint8_t> bytes(read.begin(), read.end());
  std::fprintf(stderr, "replaying %s\n", path.c_str());
  accel::fuzz::require(in.good() || in.eof(), "cannot read " + path.string());
  LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t count = 0;
  for (int i = 1; i < argc; ++i)
    for (const fs::path& file : files_in(argv[i])) replay(file), ++count;
  std::printf("replayed %zu files\n", count);
  return count > 0 ? 0 : 1;
}
