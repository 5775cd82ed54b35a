#include "libaccel/build/kdtree_split.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include "libaccel/build/parallel.h"
#include "libaccel/geometry/clip_triangle.h"

namespace accel {
namespace {

// Where a reference goes: to one child, with its index there, or to both.
enum Side : std::uint32_t { kLower = 0, kUpper = 1, kBoth = 2 };
constexpr std::uint32_t kSideShift = 30, kIndexMask = (1u << kSideShift) - 1;

constexpr std::uint32_t kNowhere = 0xffffffffu;

// References of a chunk; after prefix sums, those of the chunks before.
struct ChunkCounts {
  std::uint32_t straddlers = 0, lower = 0, upper = 0;

  ChunkCounts& operator+=(const ChunkCounts& other) {
    straddlers += other.straddlers, lower += other.lower, upper += other.upper;
    return *this;
  }
};

// Turns the counts of `n` chunks into those of the chunks before, and returns the sum.
ChunkCounts exclusive_sums(ChunkCounts* counts, std::size_t n) {
  ChunkCounts sum;
  for (std::size_t i = 0; i < n; ++i) {
    const ChunkCounts count = counts[i];
    counts[i] = sum;
    sum += count;
  }
  return sum;
}

void allocate_child(KdSet& child, std::uint32_t size, ScratchStack& memory) {
  child.size = size;
  child.references = memory.allocate<Reference>(size);
  // One more than there can be: filters write before they know whether an event counts.
  for (KdEventList& list : child.axis) list.events = memory.allocate<KdEvent>(2 * std::size_t{size} + 1);
}

// Appends those of the events [first, last) that belong to references of one child to the lists of that child. Without
// branches: each event is written to both lists, and one of them keeps it.
void filter_events(const KdEvent* first, const KdEvent* last, const std::uint32_t* fates, KdEventList& lower,
                   KdEventList& upper) {
  for (; first != last; ++first) {
    const KdEvent event = *first;
    const std::uint32_t fate = fates[reference_of(event)], side = fate >> kSideShift, start = is_start(event) ? 1 : 0;
    const KdEvent moved = (event & ~kEventReference) | (fate & kIndexMask);
    lower.events[lower.size] = moved, upper.events[upper.size] = moved;
    const std::uint32_t is_lower = side == kLower ? 1 : 0, is_upper = side == kUpper ? 1 : 0;
    lower.size += is_lower, lower.starts += is_lower & start;
    upper.size += is_upper, upper.starts += is_upper & start;
  }
}

void sort_events(KdEvent* first, std::size_t count) {
  if (count < kParallelSize) {
    std::sort(first, first + count);
  } else {
    tbb::parallel_sort(first, first + count);
  }
}

// Merges sorted events into the list, which has room for them: from the back, so that they find their places.
void merge_events(KdEventList& list, const KdEventList& added) {
  std::uint32_t from = list.size, next = added.size, to = list.size + added.size;
  list.size = to, list.starts += added.starts;
  while (next > 0) {
    if (from > 0 && list.events[from - 1] > added.events[next - 1]) {
      list.events[--to] = list.events[--from];
    } else {
      list.events[--to] = added.events[--next];
    }
  }
}

// Shares the room of a set out in proportion to the children's sizes.
void share_limit(const KdSet& set, KdSet (&children)[2]) {
  const std::uint64_t lower = children[0].size, upper = children[1].size, both = std::max<std::uint64_t>(lower + upper, 1);
  // 53 bits suffice: a limit is at most kMaxTriangles times kMaxKdReferences.
  const auto spare = static_cast<double>(set.limit - lower - upper);
  children[0].limit = lower + static_cast<std::uint64_t>(spare * static_cast<double>(lower) / static_cast<double>(both));
  children[1].limit = set.limit - children[0].limit;
}

template <class Body>
void for_each_axis(std::size_t size, const Body& body) {
  if (size < kParallelSize) {
    for (int a = 0; a < 3; ++a) body(a);
  } else {
    tbb::parallel_for(0, 3, body);
  }
}

}  // namespace

// The two parts of a reference that the plane cuts; `side` is the index in the child, or kNowhere.
struct KdSplitter::Straddler {
  Reference part[2];
};

struct KdSplitter::Work {
  const KdSet& set;
  const KdPlane& plane;
  KdSet (&children)[2];
  std::uint32_t* fates;  // by reference: side, and index in the child
  ChunkCounts* chunks;
  Straddler* straddlers = nullptr;
  std::uint32_t straddler_count = 0;
};

KdSplitter::KdSplitter(const TriangleMesh& mesh, const Aabb& scene) : mesh_(mesh), scene_(scene) {
  double magnitude = 0;
  for (int a = 0; a < 3; ++a)
    magnitude = std::max({magnitude, std::abs(static_cast<double>(scene.lo[a])), std::abs(static_cast<double>(scene.hi[a]))});
  const Vec3d pad = cell_padding(scene);
  const double slack = 128 * 0x1p-53 * magnitude;
  reach_[0] = pad.x + slack, reach_[1] = pad.y + slack, reach_[2] = pad.z + slack;
}

KdSet KdSplitter::root_set(const Reference* references, std::size_t count, ScratchStack& memory) const {
  const Vec3d reach{reach_[0], reach_[1], reach_[2]};
  KdSet set;
  set.cell = padded(scene_, reach);
  allocate_child(set, static_cast<std::uint32_t>(count), memory);
  for_each_chunk(0, count, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      set.references[i] = references[i];
      set.references[i].set_bounds(padded(references[i].bounds(), reach));
    }
  });
  for_each_axis(count, [&](int a) {
    for (std::uint32_t i = 0; i < set.size; ++i)
      set.axis[a].append(set.references[i].lo[a], set.references[i].hi[a], set.cell.lo[a], set.cell.hi[a], i);
    sort_events(set.axis[a].events, set.axis[a].size);
  });
  return set;
}

std::size_t KdSplitter::split(const KdSet& set, const KdPlane& plane, ScratchStack& scratch, ScratchStack& lower_memory,
                              ScratchStack& upper_memory, KdSet (&children)[2]) const {
  const ScratchStack::Mark mark = scratch.mark();
  for (KdSet& child : children) child.cell = set.cell, child.levels = set.levels - 1;
  children[0].cell.hi[plane.axis] = children[1].cell.lo[plane.axis] = plane.position;

  Work work{set, plane, children, scratch.allocate<std::uint32_t>(set.size),
            scratch.allocate<ChunkCounts>(chunk_count(set.size))};
  classify(work);
  work.straddlers = scratch.allocate<Straddler>(work.straddler_count);
  clip(work);
  const ChunkCounts sum = exclusive_sums(work.chunks, chunk_count(set.size));
  allocate_child(children[0], sum.lower, lower_memory);
  allocate_child(children[1], sum.upper, upper_memory);
  share_limit(set, children);
  distribute(work);
  if (set.size < kParallelSize) {
    for (int a = 0; a < 3; ++a) distribute_events(work, a, scratch);
  } else {
    tbb::parallel_for(0, 3, [&](int a) {
      ScratchStack own(scratch.meter());
      distribute_events(work, a, own);
    });
  }
  scratch.release(mark);
  return set.size + work.straddler_count - children[0].size - children[1].size;
}

// Says for each reference which cells it has a part in, by its box.
void KdSplitter::classify(Work& work) const {
  const int axis = work.plane.axis;
  const float position = work.plane.position;
  for_chunks(0, work.set.size, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    ChunkCounts counts;
    for (std::size_t i = begin; i < end; ++i) {
      const Reference& r = work.set.references[i];
      const bool above = r.hi[axis] > position, both = above && r.lo[axis] < position;
      work.fates[i] = (both ? kBoth : above ? kUpper : kLower) << kSideShift;
      counts.straddlers += both, counts.lower += !above, counts.upper += above && !both;
    }
    work.chunks[chunk] = counts;
  });
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < chunk_count(work.set.size); ++i) {
    const std::uint32_t straddlers = work.chunks[i].straddlers;
    work.chunks[i].straddlers = count;
    count += straddlers;
  }
  work.straddler_count = count;
}

// Cuts the references that lie in both cells.
void KdSplitter::clip(Work& work) const {
  for_chunks(0, work.set.size, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    ChunkCounts& counts = work.chunks[chunk];
    Straddler* straddler = work.straddlers + counts.straddlers;
    counts.straddlers = 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (work.fates[i] >> kSideShift != kBoth) continue;
      clip_straddler(work, static_cast<std::uint32_t>(i), *straddler);
      counts.lower += straddler->part[0].side != kNowhere, counts.upper += straddler->part[1].side != kNowhere;
      ++straddler, ++counts.straddlers;
    }
  });
}

void KdSplitter::clip_straddler(const Work& work, std::uint32_t reference, Straddler& straddler) const {
  const Reference& whole = work.set.references[reference];
  const Aabb& cell = work.set.cell;
  ClippedPolygon polygon(mesh_.triangle(whole.prim_id));
  for (int a = 0; a < 3; ++a) {
    polygon.clip(a, cell.lo[a] - reach_[a], 1);
    polygon.clip(a, cell.hi[a] + reach_[a], -1);
  }
  for (int c = 0; c < 2; ++c) {
    ClippedPolygon part = polygon;
    const double sign = c == 0 ? -1 : 1;
    part.clip(work.plane.axis, work.plane.position - sign * reach_[work.plane.axis], sign);

    const Aabb& child = work.children[c].cell;
    Reference& result = straddler.part[c];
    result.prim_id = whole.prim_id, result.side = part.empty() ? kNowhere : 0;
    for (int a = 0; a < 3; ++a) {
      const ClippedPolygon::Range range = part.range(a);
      result.lo[a] = round_down(range.lo - reach_[a]), result.hi[a] = round_up(range.hi + reach_[a]);
      if (!(result.lo[a] < child.hi[a]) || !(result.hi[a] > child.lo[a])) result.side = kNowhere;
    }
  }
}

// Writes the children's references, in the order of the set's, and where each went.
void KdSplitter::distribute(Work& work) const {
  for_chunks(0, work.set.size, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    ChunkCounts next = work.chunks[chunk];
    const auto put = [&](int c, const Reference& reference) {
      std::uint32_t& index = c == 0 ? next.lower : next.upper;
      work.children[c].references[index] = reference;
      return index++;
    };
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t side = work.fates[i] >> kSideShift;
      if (side != kBoth) {
        work.fates[i] |= put(static_cast<int>(side), work.set.references[i]);
        continue;
      }
      for (int c = 0; c < 2; ++c) {
        Reference& part = work.straddlers[next.straddlers].part[c];
        if (part.side != kNowhere) part.side = put(c, part);
      }
      ++next.straddlers;
    }
  });
}

void KdSplitter::distribute_events(Work& work, int axis, ScratchStack& scratch) const {
  const KdEventList& list = work.set.axis[axis];
  const KdEvent *first = list.events, *last = first + list.size, *plane_first = last, *plane_last = last;
  if (axis == work.plane.axis) {
    // Events in the plane lie at the border of both cells.
    plane_first = std::lower_bound(first, last, make_event(work.plane.position, 0, 0));
    plane_last = std::upper_bound(
        plane_first, last, make_event(work.plane.position, kStartOfReference, static_cast<std::uint32_t>(kEventReference)));
  }
  KdEventList& lower = work.children[0].axis[axis];
  KdEventList& upper = work.children[1].axis[axis];
  filter_events(first, plane_first, work.fates, lower, upper);
  filter_events(plane_last, last, work.fates, lower, upper);

  for (int c = 0; c < 2; ++c) {
    const ScratchStack::Mark mark = scratch.mark();
    const Aabb& cell = work.children[c].cell;
    KdEventList added;
    added.events = scratch.allocate<KdEvent>(2 * std::size_t{work.straddler_count});
    for (std::uint32_t i = 0; i < work.straddler_count; ++i) {
      const Reference& part = work.straddlers[i].part[c];
      if (part.side != kNowhere) added.append(part.lo[axis], part.hi[axis], cell.lo[axis], cell.hi[axis], part.side);
    }
    sort_events(added.events, added.size);
    merge_events(c == 0 ? lower : upper, added);
    scratch.release(mark);
  }
}

}  // namespace accel
