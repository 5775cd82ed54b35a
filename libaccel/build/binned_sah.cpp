#include "libaccel/build/binned_sah.h"

#include "libaccel/build/object_splitter.h"

namespace accel {

Result<Built<Bvh2>> BinnedSah::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return run_build<Bvh2>(mesh, options, [](BuildContext& context) -> Result<Bvh2> {
    References references = make_references(context, 0);
    if (references.count == 0) return Bvh2{};

    const ObjectSplitter splitter(references.storage.data(), context.options);
    return build_bvh2(context, splitter, references);
  });
}

}  // namespace accel
