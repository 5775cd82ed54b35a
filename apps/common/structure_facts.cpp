#include "apps/common/structure_facts.h"

namespace accel::apps {

namespace {

Result<StructureFacts> facts_of_kind(const Bvh2& bvh, const TriangleMesh&, const BuildOptions&, Detail) {
  StructureFacts facts;
  facts.depth = bvh.depth;
  return facts;
}

Result<StructureFacts> facts_of_kind(const TriangleList&, const TriangleMesh&, const BuildOptions&, Detail) {
  return StructureFacts{};
}

}  // namespace

Result<StructureFacts> facts_of(const AnyStructure& structure, const TriangleMesh& mesh, const BuildOptions& options,
                                Detail detail) {
  return std::visit([&](const auto& s) { return facts_of_kind(s, mesh, options, detail); }, structure);
}

}  // namespace accel::apps
