#include "libaccel/build/references.h"

#include <algorithm>
#include <vector>

#include "libaccel/build/parallel.h"
#include "libaccel/geometry/mesh_facts.h"

namespace accel {
namespace {

// What one chunk of triangles yields.
struct Chunk {
  std::size_t kept = 0;
  Skipped skipped;
  SetBounds bounds;
};

// Negative zeros become positive.
Vec3 without_signed_zeros(Vec3 p) { return p + Vec3{}; }

// Writes the references of triangles [begin, end) to `out`, without gaps.
Chunk reference_chunk(const TriangleMesh& mesh, std::size_t begin, std::size_t end, Reference* out) {
  Chunk chunk;
  for (std::size_t i = begin; i < end; ++i) {
    const Triangle triangle = mesh.triangle(i);
    if (!is_in_range(triangle)) {
      ++chunk.skipped.out_of_range;
      continue;
    }
    if (is_zero_area(triangle)) {
      ++chunk.skipped.zero_area;
      continue;
    }
    const Aabb box = triangle.bounds();
    Reference& reference = out[chunk.kept++];
    reference = {without_signed_zeros(box.lo), static_cast<std::uint32_t>(i), without_signed_zeros(box.hi), 0};
    chunk.bounds.extend(reference.box());
  }
  return chunk;
}

}  // namespace

SetBounds bounds_of(const Reference* references, std::size_t begin, std::size_t end) {
  return reduce_chunks<SetBounds>(begin, end, [&](std::size_t b, std::size_t e) {
    SetBounds bounds;
    for (std::size_t i = b; i < e; ++i) bounds.extend(references[i].box());
    return bounds;
  });
}

References make_references(BuildContext& context, std::size_t spare) {
  context.begin_phase("references");
  const TriangleMesh& mesh = context.mesh;
  References result;
  result.storage = Buffer<Reference>(mesh.size() + spare);
  context.memory.add(result.storage.size_bytes());

  std::vector<Chunk> chunks(chunk_count(mesh.size()));
  Reference* const references = result.storage.data();
  for_each_chunk(0, mesh.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    chunks[chunk] = reference_chunk(mesh, begin, end, references + begin);
  });

  // Close the gaps that skipped triangles left.
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    const Chunk& chunk = chunks[i];
    const Reference* const from = references + i * kChunk;
    if (from != references + result.count) std::copy(from, from + chunk.kept, references + result.count);
    result.count += chunk.kept;
    result.bounds += chunk.bounds;
    context.report.skipped.out_of_range += chunk.skipped.out_of_range;
    context.report.skipped.zero_area += chunk.skipped.zero_area;
  }
  context.report.triangles = result.count;
  return result;
}

}  // namespace accel
