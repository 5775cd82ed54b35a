#include "libaccel/structure/reference_leaf.h"

#include <string>

namespace accel {

Status validate(const ReferenceLeaves& leaves, std::uint64_t triangle_count) {
  const auto there_are = [](std::uint64_t count) { return ", but there are " + std::to_string(count); };
  const std::uint64_t slots = leaves.triangles.size(), references = leaves.references.size();
  if (slots >= kLastReference || references >= kEmptyLeaf)
    return Error{"there are " + std::to_string(slots) + " slots and " + std::to_string(references) +
                 " references, more than links can name"};
  for (std::size_t slot = 0; slot < slots; ++slot)
    if (leaves.triangles[slot].prim_id() >= triangle_count)
      return Error{"slot " + std::to_string(slot) + " holds triangle " + std::to_string(leaves.triangles[slot].prim_id()) +
                   there_are(triangle_count)};
  for (std::size_t i = 0; i < references; ++i)
    if (slot_of(leaves.references[i]) >= slots)
      return Error{"reference " + std::to_string(i) + " names slot " + std::to_string(slot_of(leaves.references[i])) +
                   there_are(slots)};
  if (references > 0 && !is_last(leaves.references[references - 1])) return Error{"the last leaf has no end"};
  return Done{};
}

}  // namespace accel
