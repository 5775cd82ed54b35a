#include "apps/common/structure_facts.h"

namespace accel::apps {

namespace {

StructureFacts facts_of_kind(const Bvh2& bvh, const BuildOptions&) {
  StructureFacts facts;
  facts.depth = bvh.depth;
  facts.nodes = bvh.nodes.size();
  return facts;
}

StructureFacts facts_of_kind(const TriangleList&, const BuildOptions&) { return {}; }

}  // namespace

StructureFacts facts_of(const AnyStructure& structure, const BuildOptions& options) {
  return std::visit([&](const auto& s) { return facts_of_kind(s, options); }, structure);
}

}  // namespace accel::apps
