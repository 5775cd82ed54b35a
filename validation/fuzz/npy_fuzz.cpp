// NumPy files as rays and as hits. What was read and is written again reads the same.
#include "libaccel/io/npy.h"
#include "validation/fuzz/fuzz_input.h"

namespace {

using namespace accel;

template <class T, class Write, class Read>
void check(const Result<Buffer<T>>& values, const Write& write, const Read& read) {
  if (!values) return fuzz::require(!values.message().empty(), "an error without a message");
  static const fuzz::InputFile copy(".copy.npy");
  const std::filesystem::path& path = copy.holding({});
  const Status written = write(path, values->span());
  fuzz::require(written.ok(), "what was read cannot be written");
  const Result<Buffer<T>> again = read(path);
  fuzz::require(again && again->size() == values->size(), "what was written cannot be read");
  const bool same = values->empty() || std::memcmp(again->data(), values->data(), values->size_bytes()) == 0;
  fuzz::require(same, "what was written reads differently");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile file(".npy");
  const std::filesystem::path& path = file.holding({data, size});
  const auto write_hits = [](const std::filesystem::path& to, std::span<const Hit> hits) { return write_hits_npy(to, hits); };
  check<Ray>(read_rays_npy(path), write_rays_npy, read_rays_npy);
  check<Hit>(read_hits_npy(path), write_hits, read_hits_npy);
  return 0;
}
