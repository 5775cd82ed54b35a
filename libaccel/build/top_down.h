// The recursion that top-down BVH builders share: tasks, depth, progress. How a set of references is split is the Splitter's
// business:
//
//   struct Splitter {
//     // Splits the set in two and returns true, or returns false: the set becomes a leaf. set.levels > 0.
//     bool split(const ReferenceSet& set, ReferenceSet (&children)[2]) const;
//   };
//
// Sets above kTaskSize are split one by one, their children in concurrent tasks; a smaller set becomes a treelet, built by one
// task.
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>

#include <tbb/task_group.h>

#include "libaccel/build/emit_bvh2.h"
#include "libaccel/build/references.h"
#include "libaccel/build/reinsertion.h"

namespace accel {

inline constexpr std::size_t kTaskSize = 4096;

// References [begin, end) of the builder's array, followed by room up to `limit` that is the set's own.
struct ReferenceSet {
  std::size_t begin = 0, end = 0, limit = 0;
  SetBounds bounds;
  int levels = 0;  // inner nodes that a path may still have

  std::size_t size() const { return end - begin; }
  std::size_t spare() const { return limit - end; }
};

// Whether only balanced splits keep a set of this size within its levels: a child with all but one of the references, and one
// level less, could not be split into leaves of the allowed size any more.
inline bool must_balance(std::size_t size, int levels, int max_leaf_size) {
  if (levels > 32) return false;
  const auto capacity = static_cast<std::uint64_t>(max_leaf_size) << std::max(levels - 1, 0);
  return size > capacity + 1;
}

template <class Splitter>
class TopDownBuilder {
 public:
  TopDownBuilder(BuildContext& context, const Splitter& splitter, ProgressMeter& progress)
      : context_(context), splitter_(splitter), progress_(progress) {}

  // The tree over a set that is not empty. When progress says stop, what is left is put into leaves.
  std::unique_ptr<Subtree> build(const ReferenceSet& set) {
    auto tree = std::make_unique<Subtree>();
    if (set.size() <= kTaskSize || !split_in_tasks(set, *tree)) build_treelet(set, tree->treelet);
    return tree;
  }

  // The most inner nodes on a path of what has been built.
  int depth() const { return depth_.load(); }

 private:
  bool split_in_tasks(const ReferenceSet& set, Subtree& tree) {
    ReferenceSet children[2];
    if (!split(set, children)) return false;
    for (int c = 0; c < 2; ++c) tree.bounds[c] = children[c].bounds.boxes.aabb();
    tbb::task_group group;
    group.run([&] { tree.child[1] = build(children[1]); });
    tree.child[0] = build(children[0]);
    group.wait();
    return true;
  }

  void build_treelet(const ReferenceSet& set, Treelet& treelet) {
    if (progress_.stopped()) return;
    treelet.nodes.reserve(set.size() / 2), treelet.leaves.reserve(set.size() / 2);
    int deepest = 0;
    treelet.root = build_node(set, treelet, deepest);
    context_.memory.add(treelet.size_bytes());
    progress_.advance(set.size());
    for (int seen = depth_.load(); deepest > seen && !depth_.compare_exchange_weak(seen, deepest);) {
    }
  }

  NodeRef build_node(const ReferenceSet& set, Treelet& treelet, int& deepest) {
    ReferenceSet children[2];
    if (!split(set, children)) {
      deepest = std::max(deepest, context_.options.max_depth - set.levels);
      return treelet.add_leaf(set.begin, set.size());
    }
    const std::size_t index = treelet.nodes.size();
    treelet.nodes.emplace_back();
    for (int c = 0; c < 2; ++c) {
      treelet.nodes[index].set_bounds(c, children[c].bounds.boxes.aabb());
      const NodeRef child = build_node(children[c], treelet, deepest);
      treelet.nodes[index].child[c] = child;
    }
    return static_cast<NodeRef>(index);
  }

  // Splits, the child that is more likely to be hit first.
  bool split(const ReferenceSet& set, ReferenceSet (&children)[2]) {
    if (set.levels == 0 || set.size() == 1 || progress_.stopped() || !splitter_.split(set, children)) return false;
    const Float4 one = Float4::splat(1.0f);
    if (children[0].bounds.boxes.half_area(one) < children[1].bounds.boxes.half_area(one)) std::swap(children[0], children[1]);
    children[0].levels = children[1].levels = set.levels - 1;
    return true;
  }

  BuildContext& context_;
  const Splitter& splitter_;
  ProgressMeter& progress_;
  std::atomic<int> depth_{0};
};

// The whole build after make_references(): splits all references, the room behind them included, emits the structure, and
// improves it as the options say. The references are given up.
template <class Splitter>
Result<Bvh2> build_bvh2(BuildContext& context, const Splitter& splitter, References& references) {
  context.begin_phase("split");
  ProgressMeter progress(context.options.progress, "split", references.count);
  TopDownBuilder<Splitter> builder(context, splitter, progress);
  std::unique_ptr<Subtree> tree =
      builder.build({0, references.count, references.storage.size(), references.bounds, context.options.max_depth});
  if (progress.stopped()) return Error{std::string(kInterrupted)};

  Result<Bvh2> bvh = emit_bvh2(context, std::move(tree), references.storage.data());
  if (!bvh) return bvh;
  bvh->bounds = references.bounds.boxes.aabb();
  bvh->depth = static_cast<std::uint32_t>(builder.depth());
  context.memory.subtract(references.storage.size_bytes());
  references.storage = {};
  if (const Status improved = reinsert(context, *bvh); !improved) return improved.error();
  return bvh;
}

}  // namespace accel
