#include "libaccel/build/refit_wide.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "libaccel/build/build_context.h"
#include "libaccel/build/parallel.h"
#include "libaccel/build/wide_node.h"
#include "libaccel/core/out_of_memory.h"
#include "libaccel/geometry/mesh_facts.h"

namespace accel {
namespace {

// A triangle that cannot be refitted; the lowest of those that threads find.
class FirstBad {
 public:
  void note(std::uint32_t prim_id) {
    std::uint32_t seen = least_.load(std::memory_order_relaxed);
    while (prim_id < seen && !least_.compare_exchange_weak(seen, prim_id, std::memory_order_relaxed)) {
    }
  }
  bool found() const { return least_.load() != kNoHit; }
  std::string name() const { return "triangle " + std::to_string(least_.load()); }

 private:
  std::atomic<std::uint32_t> least_{kNoHit};
};

struct CostSums {
  double before = 0, after = 0;
  CostSums& operator+=(const CostSums& other) { return before += other.before, after += other.after, *this; }
};

class Refit {
 public:
  Refit(const Bvh8& bvh, const TriangleMesh& mesh, const BuildOptions& options) : old_(bvh), mesh_(mesh), options_(options) {}

  Result<RefittedBvh8> run() {
    static_cast<Bvh8Words&>(new_) = old_;
    if (Status s = move_triangles(); !s) return s.error();
    if (Status s = check_absent(); !s) return s.error();
    if (old_.root != kNoNode) move_boxes();
    return RefittedBvh8{new_, costs(), 0};
  }

 private:
  // ---- triangles
  Status move_triangles() {
    new_.blocks = Buffer<TriangleBlock>(old_.blocks.size());
    boxes_ = Buffer<Aabb>(old_.blocks.size());
    FirstBad unknown, out_of_range;
    for_chunks(0, old_.blocks.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) move_block(b, unknown, out_of_range);
    });
    if (unknown.found())
      return Error{"refitting: the tree has " + unknown.name() + ", but the mesh has " + std::to_string(mesh_.size()) +
                   " triangles; refit with the triangles that it was built over, or rebuild"};
    if (out_of_range.found())
      return Error{"refitting: " + out_of_range.name() +
                   " has a coordinate that is not finite or too large; rebuild without it"};
    return Done{};
  }

  void move_block(std::size_t b, FirstBad& unknown, FirstBad& out_of_range) {
    TriangleBlock block = old_.blocks[b];
    Aabb box;
    for (std::uint32_t lane = 0; lane < kBlockLanes && block.has(lane); ++lane) {
      const std::uint32_t prim_id = block.prim_id[lane];
      if (prim_id >= mesh_.size()) return unknown.note(prim_id);
      const Triangle triangle = mesh_.triangle(prim_id);
      if (!is_in_range(triangle)) return out_of_range.note(prim_id);
      block.set(lane, pack(triangle, prim_id));
      box.extend(triangle.bounds());
    }
    new_.blocks[b] = block;
    boxes_[b] = {box.lo + Vec3{}, box.hi + Vec3{}};  // without negative zeros, as built
  }

  // Whether no ray can hit the triangles that the tree does not have.
  Status check_absent() const {
    std::vector<bool> has(mesh_.size());
    for (const TriangleBlock& block : old_.blocks)
      for (std::uint32_t lane = 0; lane < kBlockLanes && block.has(lane); ++lane) has[block.prim_id[lane]] = true;
    for (std::size_t i = 0; i < mesh_.size(); ++i) {
      if (has[i]) continue;
      if (const Triangle triangle = mesh_.triangle(i); is_in_range(triangle) && !is_zero_area(triangle))
        return Error{"refitting: triangle " + std::to_string(i) +
                     " can be hit now, but the tree was built without it; rebuild"};
    }
    return Done{};
  }

  // ---- boxes
  void move_boxes() {
    if (is_leaf(old_.root)) {
      new_.bounds = leaf_box(old_.root);
      return;
    }
    new_.nodes = Buffer<Bvh8Node>(old_.nodes.size());
    const std::vector<std::size_t> levels = list_levels();
    for (std::size_t l = levels.size() - 1; l-- > 0;)
      sums_ += reduce_chunks<CostSums>(levels[l], levels[l + 1], [&](std::size_t begin, std::size_t end) {
        CostSums sums;
        for (std::size_t i = begin; i < end; ++i) sums += move_node(order_[i]);
        return sums;
      });
    new_.bounds = bounds_of_children(new_.nodes[new_.root]);
  }

  // All nodes, level by level; where each level begins, and where the last ends.
  std::vector<std::size_t> list_levels() {
    order_.reserve(old_.nodes.size());
    order_.push_back(old_.root);
    std::vector<std::size_t> levels{0};
    for (std::size_t i = 0; i < order_.size(); levels.push_back(i))
      for (const std::size_t end = order_.size(); i < end; ++i)
        for (const NodeRef child : old_.nodes[order_[i]].child)
          if (!is_leaf(child)) order_.push_back(child);
    return levels;
  }

  CostSums move_node(NodeRef ref) {
    const Bvh8Node& node = old_.nodes[ref];
    WideChild children[kBvh8Arity];
    std::uint32_t count = 0;
    CostSums sums;
    for (; count < kBvh8Arity && node.child[count] != kNoNode; ++count) {
      const NodeRef child = node.child[count];
      const Aabb box = is_leaf(child) ? leaf_box(child) : bounds_of_children(new_.nodes[child]);
      children[count] = {child, Box4::of(box)};
      const double cost = is_leaf(child) ? double{options_.intersection_cost} * block_count(old_.blocks, child)
                                         : double{options_.traversal_cost};
      sums += {cost * half_area_in_double(node.bounds(count)), cost * half_area_in_double(box)};
    }
    make_wide_node(children, count, new_.nodes[ref]);
    return sums;
  }

  Aabb leaf_box(NodeRef leaf) const {
    Aabb box;
    const std::uint32_t first = first_block(leaf), blocks = block_count(old_.blocks, leaf);
    for (std::uint32_t b = first; b < first + blocks; ++b) box.extend(boxes_[b]);
    return box;
  }

  RefitCosts costs() const {
    if (old_.root == kNoNode) return {};
    const double root = is_leaf(old_.root) ? double{options_.intersection_cost} * block_count(old_.blocks, old_.root)
                                           : double{options_.traversal_cost};
    const auto cost = [&](double sum, const Aabb& bounds) {
      const double area = half_area_in_double(bounds);
      return area > 0 ? root + sum / area : 0.0;
    };
    return {cost(sums_.before, old_.bounds), cost(sums_.after, new_.bounds)};
  }

  const Bvh8& old_;
  const TriangleMesh& mesh_;
  const BuildOptions& options_;
  Bvh8 new_;
  Buffer<Aabb> boxes_;          // by block
  std::vector<NodeRef> order_;  // nodes, level by level
  CostSums sums_;
};

}  // namespace

Result<RefittedBvh8> refit_wide(const Bvh8& bvh, const TriangleMesh& mesh, const BuildOptions& options) try {
  if (Status s = validate(options); !s) return s.error();
  const auto start = std::chrono::steady_clock::now();
  tbb::task_arena arena(arena_size(options.threads));
  Result<RefittedBvh8> refitted = arena.execute([&] { return Refit(bvh, mesh, options).run(); });
  if (refitted) refitted->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return refitted;
} catch (const std::bad_alloc&) {
  return out_of_memory("refitting a tree");
}

}  // namespace accel
