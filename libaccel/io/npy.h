// Rays and hits as NumPy's .npy files (versions 1.0, 2.0 and 3.0 are read, 1.0 is written).
//
// Rays are a float32 array of shape (N, 8), a row being org x y z, t_min, dir x y z, t_max: the memory layout of Ray. Read are
// also shape (N, 6), org and dir with t_min = 0 and t_max = infinity, float64 (rounded to float), big-endian and Fortran order.
// Values may be anything; is_traceable() says which rays can hit.
//
// Hits are a structured array of shape (N,) with the fields t, u, v (float32) and prim_id (uint32), the memory layout of Hit:
//
//   hits = numpy.load("hits.npy"); hits["t"][hits["prim_id"] != 0xffffffff]
//
// Files are written whole or not at all (io/atomic_file.h). Errors name the file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "libaccel/core/buffer.h"
#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/core/result.h"

namespace accel {

Status write_rays_npy(const std::filesystem::path& path, std::span<const Ray> rays);
Result<Buffer<Ray>> read_rays_npy(const std::filesystem::path& path);
// How many there are, without reading them; the errors are the same.
Result<std::uint64_t> count_rays_npy(const std::filesystem::path& path);

Status write_hits_npy(const std::filesystem::path& path, std::span<const Hit> hits);

// Several hits a ray, as an array of shape (N, K): K is per_ray, at least 1, and N * K the number of hits (else an
// error). Misses fill up.
Status write_hits_npy(const std::filesystem::path& path, std::span<const Hit> hits, std::size_t per_ray);

Result<Buffer<Hit>> read_hits_npy(const std::filesystem::path& path);

}  // namespace accel
