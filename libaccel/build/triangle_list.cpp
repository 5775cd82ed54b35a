#include "libaccel/build/triangle_list.h"

#include "libaccel/build/leaf_stream.h"
#include "libaccel/build/references.h"

namespace accel {

Result<Built<TriangleList>> ListBuilder::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return run_build<TriangleList>(mesh, options, [](BuildContext& context) -> Result<TriangleList> {
    const References references = make_references(context, 0);
    context.begin_phase("emit");
    TriangleList list;
    list.leaves = Buffer<LeafQuad>(references.count * kQuadsPerTriangle + 1);
    context.memory.add(list.size_bytes());
    context.report.references = references.count;

    LeafQuad* quad = list.leaves.data();
    for (std::size_t i = 0; i < references.count; ++i) quad = write_triangle(context.mesh, references.storage[i].prim_id, quad);
    write_end_of_leaf(quad);
    return list;
  });
}

}  // namespace accel
