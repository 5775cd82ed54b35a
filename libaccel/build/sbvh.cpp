#include "libaccel/build/sbvh.h"

#include <algorithm>

#include "libaccel/build/spatial_splitter.h"

namespace accel {

Result<Built<Bvh2>> Sbvh::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return run_build<Bvh2>(mesh, options, [](BuildContext& context) -> Result<Bvh2> {
    // Leaf runs count references in 32 bits.
    const auto spare = [&](std::size_t triangles) {
      const auto count = static_cast<double>(triangles);
      return static_cast<std::size_t>(
          std::min(static_cast<double>(context.options.max_duplication) * count, 0xffffffffu - count));
    };
    References references = make_references(context, spare(context.mesh.size()));
    if (references.count == 0) return Bvh2{};
    references.storage.truncate(references.count + spare(references.count));  // triangles left out leave no room for others

    const SpatialSplitter splitter(context.mesh, references.storage.data(), references.bounds.boxes, context.options);
    return build_bvh2(context, splitter, references);
  });
}

}  // namespace accel
