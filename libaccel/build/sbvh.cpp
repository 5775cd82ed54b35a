#include "libaccel/build/sbvh.h"

#include <algorithm>

#include "libaccel/build/spatial_splitter.h"

namespace accel {

Result<Built<Bvh2>> Sbvh::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return run_build<Bvh2>(mesh, options, [](BuildContext& context) -> Result<Bvh2> {
    // Leaf runs count references in 32 bits.
    const double triangles = static_cast<double>(context.mesh.size());
    const double spare = std::min(static_cast<double>(context.options.max_duplication) * triangles, 0xffffffffu - triangles);
    References references = make_references(context, static_cast<std::size_t>(spare));
    if (references.count == 0) return Bvh2{};

    const SpatialSplitter splitter(context.mesh, references.storage.data(), references.bounds.boxes, context.options);
    return build_bvh2(context, splitter, references);
  });
}

}  // namespace accel
