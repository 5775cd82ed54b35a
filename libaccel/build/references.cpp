#include "libaccel/build/references.h"

#include <algorithm>
#include <vector>

#include "libaccel/build/parallel.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/geometry/plain_triangle.h"

namespace accel {
namespace {

// What one chunk of triangles yields.
struct Chunk {
  std::size_t kept = 0;
  Skipped skipped;
  SetBounds bounds;
};

// Whether a ray can hit a triangle of which is_plain_triangle() does not know it; counts it if not.
bool can_be_hit(const Triangle& triangle, Skipped& skipped) {
  if (!is_in_range(triangle)) return ++skipped.out_of_range, false;
  if (is_zero_area(triangle)) return ++skipped.zero_area, false;
  return true;
}

// Calls put(i, box) for triangles in [begin, end) that rays can hit, and skip(i) for the others. The inner loop is for plain
// triangles: it calls nothing, so that what it sums up stays in registers.
template <class Put, class Skip>
Chunk each_box(const TriangleMesh& mesh, std::size_t begin, std::size_t end, const Put& put, const Skip& skip) {
  Chunk chunk;
  const IndexTriple* const triangles = mesh.triangles.data();
  const Vec3* const vertices = mesh.vertices.data();
  SetBounds bounds;
  const auto visit = [&](std::size_t i, bool only_if_plain) {
    const IndexTriple& t = triangles[i];
    const Float4 v0 = load_point(vertices[t.v0]), v1 = load_point(vertices[t.v1]), v2 = load_point(vertices[t.v2]);
    if (only_if_plain && !is_plain_triangle(v0, v1, v2)) return false;
    const Float4 zero = Float4::splat(0.0f);  // added, it makes negative zeros positive
    const Box4 box{min_of(min_of(v0, v1), v2) + zero, max_of(max_of(v0, v1), v2) + zero};
    put(i, box);
    bounds.extend(box);
    return true;
  };
  std::size_t skipped = 0;
  for (std::size_t i = begin;; ++i) {
    while (i < end && visit(i, true)) ++i;
    if (i == end) break;
    if (can_be_hit(mesh.triangle(i), chunk.skipped))
      visit(i, false);
    else
      skip(i), ++skipped;
  }
  chunk.kept = end - begin - skipped, chunk.bounds = bounds;
  return chunk;
}

// Writes the references of triangles [begin, end) to `out`, without gaps.
Chunk dense_chunk(const TriangleMesh& mesh, std::size_t begin, std::size_t end, Reference* out) {
  const auto put = [&](std::size_t i, const Box4& box) { (out++)->set(box, static_cast<std::uint32_t>(i)); };
  return each_box(mesh, begin, end, put, [](std::size_t) {});
}

// The same, each in the place of its triangle.
Chunk sparse_chunk(const TriangleMesh& mesh, std::size_t begin, std::size_t end, Reference* out) {
  const auto put = [&](std::size_t i, const Box4& box) { out[i - begin].set(box, static_cast<std::uint32_t>(i)); };
  return each_box(mesh, begin, end, put, [&](std::size_t i) { put(i, Box4{}); });
}

void report(BuildContext& context, const std::vector<Chunk>& chunks, References& result) {
  for (const Chunk& chunk : chunks) {
    result.count += chunk.kept;
    result.bounds += chunk.bounds;
    context.report.skipped.out_of_range += chunk.skipped.out_of_range;
    context.report.skipped.zero_area += chunk.skipped.zero_area;
  }
  context.report.triangles = result.count;
}

template <class MakeChunk>
References make_all(BuildContext& context, std::size_t spare, std::vector<Chunk>& chunks, const MakeChunk& make_chunk) {
  context.begin_phase("references");
  const TriangleMesh& mesh = context.mesh;
  References result;
  result.storage = Buffer<Reference>(mesh.size() + spare);
  context.memory.add(result.storage.size_bytes());
  chunks.resize(chunk_count(mesh.size()));
  Reference* const references = result.storage.data();
  for_each_chunk(0, mesh.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    chunks[chunk] = make_chunk(mesh, begin, end, references + begin);
  });
  report(context, chunks, result);
  return result;
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
  std::vector<Chunk> chunks;
  References result = make_all(context, spare, chunks, dense_chunk);
  // Close the gaps that skipped triangles left.
  Reference *const references = result.storage.data(), *to = references;
  for (std::size_t i = 0; i < chunks.size(); to += chunks[i++].kept)
    if (const Reference* const from = references + i * kChunk; from != to) std::copy(from, from + chunks[i].kept, to);
  return result;
}

References make_sparse_references(BuildContext& context) {
  std::vector<Chunk> chunks;
  return make_all(context, 0, chunks, sparse_chunk);
}

}  // namespace accel
