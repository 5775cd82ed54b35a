#include "libaccel/build/spatial_splitter.h"

#include <algorithm>
#include <vector>

#include "libaccel/build/parallel.h"
#include "libaccel/geometry/clip_triangle.h"

namespace accel {
namespace {

// Where a reference goes.
enum SplitSide : std::uint32_t { kLeft = 0, kRight = 1, kBoth = 2 };

// A reference that the plane cuts goes to both sides, or, where that is cheaper, uncut to one of them: section 4.4, "reference
// unsplitting".
SplitSide choose_side(const Box4& whole, const TriangleParts& parts, const SpatialSplit& split, Float4 scale) {
  if (parts.left.empty()) return kRight;
  if (parts.right.empty()) return kLeft;
  const auto area_with = [&](int side) {
    Box4 box = split.box[side];
    box.extend(whole);
    return box.half_area(scale);
  };
  const float left_count = static_cast<float>(split.count[0]), right_count = static_cast<float>(split.count[1]);
  const float left_area = split.box[0].half_area(scale), right_area = split.box[1].half_area(scale);
  const float both = left_area * left_count + right_area * right_count;
  const float left = area_with(0) * left_count + right_area * (right_count - 1);
  const float right = left_area * (left_count - 1) + area_with(1) * right_count;
  if (left < both && left <= right) return kLeft;
  return right < both ? kRight : kBoth;
}

// How many slabs a set of n references deserves. The triangles of small sets span most of their box: every further slab cuts
// all of them once more, and shows little that the fewer did not.
int slabs_for(std::size_t n, const BuildOptions& options) {
  return static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(std::min(options.bins, kMaxSpatialBins)), 4 + n / 4));
}

// Moves references[begin, end) up by `distance`, without keeping their order.
void move_up(Reference* references, std::size_t begin, std::size_t end, std::size_t distance) {
  const std::size_t moved = std::min(distance, end - begin);
  std::copy(references + begin, references + begin + moved, references + end + distance - moved);
}

// Shares the set's spare room out in proportion to the children's sizes: the second one moves up to make room for the first.
void share_spare(Reference* references, const ReferenceSet& set, ReferenceSet (&children)[2]) {
  ReferenceSet &left = children[0], &right = children[1];
  const std::size_t spare = set.limit - right.end;
  const std::size_t share = spare * left.size() / (left.size() + right.size());
  move_up(references, right.begin, right.end, share);
  left.limit = left.end + share;
  right.begin += share, right.end += share, right.limit = set.limit;
}

}  // namespace

SpatialSplitter::SpatialSplitter(const TriangleMesh& mesh, Reference* references, const Box4& root, const BuildOptions& options)
    : mesh_(mesh),
      references_(references),
      options_(options),
      min_overlap_(options.spatial_overlap * root.half_area(Float4::splat(1.0f))) {}

bool SpatialSplitter::overlaps(const ObjectSplit& split) const {
  if (!split.found()) return true;
  const Box4 overlap = intersection(split.left, split.right);
  return !overlap.empty() && overlap.half_area(Float4::splat(1.0f)) > min_overlap_;
}

SpatialSplit SpatialSplitter::find_spatial_split(const ReferenceSet& set) const {
  // No child may exceed what its levels can hold; it may be as large as the set.
  if (set.spare() == 0 || must_balance(set.size() + 1, set.levels, options_.max_leaf_size)) return {};
  const SlabMapping mapping(set.bounds.boxes, slabs_for(set.size(), options_));
  return SpatialBins::best_split(mesh_, references_, set.begin, set.end, set.bounds.boxes, mapping, set.spare(),
                                 options_.traversal_cost, options_.intersection_cost);
}

bool SpatialSplitter::split(const ReferenceSet& set, ReferenceSet (&children)[2]) const {
  const ObjectCandidate object = find_object_split(references_, set, options_);
  const SpatialSplit spatial = overlaps(object.split) ? find_spatial_split(set) : SpatialSplit{};
  if (is_best_as_leaf(set.size(), std::min(object.split.cost, spatial.cost), options_)) return false;
  if (!(spatial.cost < object.split.cost) || !apply_spatial_split(set, spatial, children))
    apply_object_split(references_, set, object, children);
  share_spare(references_, set, children);
  return true;
}

bool SpatialSplitter::apply_spatial_split(const ReferenceSet& set, const SpatialSplit& split,
                                          ReferenceSet (&children)[2]) const {
  const int axis = split.axis;
  const float position = split.position;
  const Float4 scale = unit_scale(set.bounds.boxes);
  const auto parts_of = [&](const Reference& r) { return split_bounds(mesh_.triangle(r.prim_id), r.box(), axis, position); };

  // Choose sides, and count the duplicates of each chunk.
  std::vector<std::size_t> duplicates(chunk_count(set.size()) + 1, 0);
  for_chunks(set.begin, set.end, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Reference& r = references_[i];
      r.side = r.hi[axis] <= position   ? kLeft
               : r.lo[axis] >= position ? kRight
                                        : choose_side(r.box(), parts_of(r), split, scale);
      duplicates[chunk + 1] += r.side == kBoth;
    }
  });
  for (std::size_t i = 1; i < duplicates.size(); ++i) duplicates[i] += duplicates[i - 1];
  if (duplicates.back() > set.spare()) return false;

  // The right parts of the references that go to both sides follow the set; their left parts take the place of the whole.
  for_chunks(set.begin, set.end, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    Reference* duplicate = references_ + set.end + duplicates[chunk];
    for (std::size_t i = begin; i < end; ++i) {
      Reference& r = references_[i];
      if (r.side != kBoth) continue;
      const TriangleParts parts = parts_of(r);
      *duplicate = r;
      duplicate->set_bounds(parts.right.aabb()), duplicate->side = kRight;
      r.set_bounds(parts.left.aabb()), r.side = kLeft;
      ++duplicate;
    }
  });
  const std::size_t end = set.end + duplicates.back();
  const Partition sides =
      partition(references_, set.begin, end, [](const Reference& r, const Box4&) { return r.side == kRight; });
  // One side is empty: then nothing was cut, for both parts of a cut reference would be there, and the set is as it was.
  if (sides.middle == set.begin || sides.middle == end) return false;
  children[0] = {set.begin, sides.middle, sides.middle, sides.side[0]};
  children[1] = {sides.middle, end, set.limit, sides.side[1]};
  return true;
}

}  // namespace accel
