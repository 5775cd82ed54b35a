#include "libaccel/build/sbvh.h"

#include "libaccel/build/spatial_splitter.h"

namespace accel {

Result<Built<Bvh2>> Sbvh::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return run_build<Bvh2>(mesh, options, [](BuildContext& context) -> Result<Bvh2> {
    const auto duplicates = static_cast<double>(context.options.max_duplication) * static_cast<double>(context.mesh.size());
    References references = make_references(context, static_cast<std::size_t>(duplicates));
    if (references.count == 0) return Bvh2{};

    const SpatialSplitter splitter(context.mesh, references.storage.data(), references.bounds.boxes, context.options);
    return build_bvh2(context, splitter, references);
  });
}

}  // namespace accel
