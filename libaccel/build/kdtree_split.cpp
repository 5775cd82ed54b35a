#include "libaccel/build/kdtree_split.h"

#include <algorithm>

#include "libaccel/build/kdtree_sort.h"
#include "libaccel/build/parallel.h"

namespace accel {
namespace {

// Where a reference goes: to one child, with its index there, or cut to both.
enum Side : std::uint32_t { kLower = 0, kUpper = 1, kCut = 2 };
constexpr std::uint32_t kSideShift = 30, kIndexMask = (1u << kSideShift) - 1;

constexpr std::uint32_t kNowhere = KdClipper::kNowhere;

// Sets up to this size get new events one by one: moving few events is less work than merging.
constexpr std::uint32_t kInsertionSize = 64;

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
  for (KdEventList& list : child.axis) list.events = memory.allocate<KdEvent>(2 * std::size_t{size});
}

// Appends each of the events [first, last) to the list of the side that its reference goes to.
void filter_events(const KdEvent* first, const KdEvent* last, const std::uint32_t* fates, KdEventList (&sides)[3]) {
  KdEvent* to[3];
  std::uint32_t starts[3] = {0, 0, 0};
  for (int side = 0; side < 3; ++side) to[side] = sides[side].events + sides[side].size;
  for (; first != last; ++first) {
    const KdEvent event = *first;
    const std::uint32_t fate = fates[event.reference()], side = fate >> kSideShift;
    *to[side]++ = {event.position, (event.word & KdEvent::kStart) | (fate & kIndexMask)};
    starts[side] += event.word >> 31;
  }
  for (int side = 0; side < 3; ++side) {
    sides[side].size = static_cast<std::uint32_t>(to[side] - sides[side].events);
    sides[side].starts += starts[side];
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

KdSet KdSplitter::root_set(const Reference* references, std::size_t count, ScratchStack& memory) const {
  KdSet set;
  set.cell = clipper_.whole(scene_);
  allocate_child(set, static_cast<std::uint32_t>(count), memory);
  for_each_chunk(0, count, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      set.references[i] = references[i];
      set.references[i].set_bounds(clipper_.whole(references[i].bounds()));
    }
  });
  for_each_axis(count, [&](int a) {
    for (std::uint32_t i = 0; i < set.size; ++i)
      set.axis[a].append(set.references[i].lo[a], set.references[i].hi[a], set.cell.lo[a], set.cell.hi[a], i);
    ScratchStack scratch(memory.meter());
    sort_events(set.axis[a].events, set.axis[a].size, scratch);
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
  for_each_axis(set.size, [&](int a) {
    ScratchStack own(scratch.meter());  // for this axis' thread; allocates nothing by itself
    distribute_events(work, a, set.size < kParallelSize ? scratch : own);
  });
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
      work.fates[i] = (both ? kCut : above ? kUpper : kLower) << kSideShift;
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
      if (work.fates[i] >> kSideShift != kCut) continue;
      clipper_.cut(work.set.references[i].prim_id, work.set.cell, work.plane, straddler->part);
      counts.lower += straddler->part[0].side != kNowhere, counts.upper += straddler->part[1].side != kNowhere;
      ++straddler, ++counts.straddlers;
    }
  });
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
      if (side != kCut) {
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
  const ScratchStack::Mark mark = scratch.mark();
  // What goes to no side as it is ends in a list that nobody reads.
  KdEventList sides[3];
  for (int c = 0; c < 2; ++c) sides[c] = work.children[c].axis[axis];
  sides[kCut].events = scratch.allocate<KdEvent>(2 * std::size_t{work.straddler_count});
  const KdEvent *first = list.events, *last = first + list.size;
  if (axis == work.plane.axis) {
    // Events in the plane lie at the border of both cells.
    const KdEvent* const plane_first = std::lower_bound(first, last, KdEvent{work.plane.position, 0});
    filter_events(first, plane_first, work.fates, sides);
    first = std::upper_bound(plane_first, last, KdEvent{work.plane.position, ~0u});
  }
  filter_events(first, last, work.fates, sides);
  for (int c = 0; c < 2; ++c) work.children[c].axis[axis] = sides[c];
  scratch.release(mark);
  if (work.straddler_count > 0) add_cut_events(work, axis, scratch);
}

// The events of references that were cut.
void KdSplitter::add_cut_events(const Work& work, int axis, ScratchStack& scratch) const {
  const bool few = work.set.size <= kInsertionSize;
  for (int c = 0; c < 2; ++c) {
    const ScratchStack::Mark mark = scratch.mark();
    const Aabb& cell = work.children[c].cell;
    KdEventList& list = work.children[c].axis[axis];
    KdEventList added;
    if (!few) added.events = scratch.allocate<KdEvent>(2 * std::size_t{work.straddler_count});
    for (std::uint32_t i = 0; i < work.straddler_count; ++i) {
      const Reference& part = work.straddlers[i].part[c];
      if (part.side == kNowhere) continue;
      if (few) {
        list.insert(part.lo[axis], part.hi[axis], cell.lo[axis], cell.hi[axis], part.side);
      } else {
        added.append(part.lo[axis], part.hi[axis], cell.lo[axis], cell.hi[axis], part.side);
      }
    }
    if (!few) {
      sort_events(added.events, added.size, scratch);
      merge_events(list, added);
    }
    scratch.release(mark);
  }
}

}  // namespace accel
