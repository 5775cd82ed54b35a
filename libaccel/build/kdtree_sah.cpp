#include "libaccel/build/kdtree_sah.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <string>

#include <tbb/task_group.h>

#include "libaccel/build/emit_kdtree.h"
#include "libaccel/build/kdtree_plane.h"
#include "libaccel/build/kdtree_split.h"

namespace accel {
namespace {

// Sets above this are split one by one, their children in concurrent tasks; a smaller set becomes a treelet, built by one task.
constexpr std::size_t kKdTaskSize = 8192;
// Where a leaf would be dear, up to so many planes on a path may cost more than the leaf, each up to so many times as much.
constexpr int kMostLosses = 4;
constexpr double kMostLoss = 2;

// What the build has to say about itself. Sums, so that they do not depend on the order of tasks.
struct KdTally {
  int least_levels = kMaxBuildDepth;  // that any leaf had left
  std::uint64_t dropped_parts = 0;    // of triangles, in cells that only their boxes come near
  std::uint64_t limited_leaves = 0;   // which would have been split if there had been room for more references
  std::uint64_t bottom_leaves = 0;    // which had triangles, but no level left

  KdTally& operator+=(const KdTally& other) {
    least_levels = std::min(least_levels, other.least_levels);
    dropped_parts += other.dropped_parts, limited_leaves += other.limited_leaves, bottom_leaves += other.bottom_leaves;
    return *this;
  }
};

class KdTreeBuilder {
 public:
  KdTreeBuilder(BuildContext& context, const KdSplitter& splitter, const KdCosts& costs, const Aabb& scene,
                ProgressMeter& progress)
      : context_(context),
        splitter_(splitter),
        costs_(costs),
        dear_(costs.dear_leaf * half_area_in_double(scene)),
        progress_(progress) {}

  // The tree over a set that lies in `memory`. When progress says stop, what is left is put into leaves.
  std::unique_ptr<KdSubtree> build(const KdSet& set, ScratchStack memory) {
    auto tree = std::make_unique<KdSubtree>();
    const KdPlane plane = set.size > kKdTaskSize ? choose_plane(set, cost_as_leaf(set)) : KdPlane{};
    if (!plane.found()) {
      build_treelet(set, memory, tree->treelet);
      return tree;
    }
    KdTally tally;
    KdSet children[2];
    ScratchStack lower(context_.memory), upper(context_.memory);
    {
      ScratchStack own = std::move(memory);  // given up before the children are built
      tally.dropped_parts = splitter_.split(set, plane, own, lower, upper, children);
    }
    add(tally);
    tree->axis = plane.axis, tree->position = plane.position;
    tbb::task_group group;
    group.run([&] { tree->child[1] = build(children[1], std::move(upper)); });
    tree->child[0] = build(children[0], std::move(lower));
    group.wait();
    return tree;
  }

  const KdTally& tally() const { return tally_; }

 private:
  // The memory and the results of one task.
  struct Task {
    ScratchStack& memory;
    ScratchStack scratch;
    KdTreelet& treelet;
  };
  // A node of a treelet, and what is known of all below it. Costs are times the half area of the cell.
  struct Branch {
    KdNode root;
    double cost;
    KdTally tally;
  };

  void build_treelet(const KdSet& set, ScratchStack& memory, KdTreelet& treelet) {
    Task task{memory, ScratchStack(context_.memory), treelet};
    treelet.cell = set.cell;
    const Branch branch = build_node(set, kMostLosses, task);
    treelet.root = branch.root;
    context_.memory.add(treelet.size_bytes());
    progress_.advance(set.limit);
    add(branch.tally);
  }

  // `losses`: how many more planes may cost more than the leaf in their place.
  Branch build_node(const KdSet& set, int losses, Task& task) {
    const double leaf_cost = cost_as_leaf(set);
    const KdPlane plane = choose_plane(set, losses > 0 && leaf_cost >= dear_ ? kMostLoss * leaf_cost : leaf_cost);
    if (!plane.found()) return build_leaf(set, plane.is_limited, task);
    const ScratchStack::Mark mark = task.memory.mark();
    const KdTreelet::Mark before = task.treelet.mark();
    KdSet children[2];
    Branch branch{};
    branch.tally.dropped_parts = splitter_.split(set, plane, task.scratch, task.memory, task.memory, children);
    const std::size_t pair = task.treelet.nodes.size();
    task.treelet.nodes.resize(pair + 2);
    branch.root = KdNode::inner(plane.axis, plane.position, static_cast<std::uint32_t>(pair));
    branch.cost = costs_.traversal * half_area_in_double(set.cell);
    for (int c = 0; c < 2; ++c) {
      const Branch child = build_node(children[c], plane.cost < leaf_cost ? losses : losses - 1, task);
      task.treelet.nodes[pair + c] = child.root;
      branch.cost += child.cost, branch.tally += child.tally;
    }
    if (children[0].size == 0 || children[1].size == 0) branch.cost *= 1 - costs_.empty_bonus;
    task.memory.release(mark);
    if (branch.cost < leaf_cost) return branch;
    task.treelet.take_back(before);
    return build_leaf(set, false, task);
  }

  // is_limited: it is a leaf for lack of room for references.
  Branch build_leaf(const KdSet& set, bool is_limited, Task& task) const {
    const KdNode leaf = task.treelet.add_leaf(set.size);
    for (std::uint32_t i = 0; i < set.size; ++i) task.treelet.references.push_back(set.references[i].prim_id);
    if (set.size > 0) task.treelet.references.back() |= kLastReference;
    return {leaf, cost_as_leaf(set), {set.levels, 0, is_limited ? 1u : 0u, set.levels == 0 && set.size > 0 ? 1u : 0u}};
  }

  double cost_as_leaf(const KdSet& set) const { return costs_.of_leaf(set.size) * half_area_in_double(set.cell); }

  // The cheapest plane, if it costs less than `most`; else one that is not found().
  KdPlane choose_plane(const KdSet& set, double most) const {
    if (set.size == 0 || set.levels == 0 || progress_.stopped()) return {};
    return cheapest_plane(set, costs_, most);
  }

  void add(const KdTally& tally) {
    const std::lock_guard lock(mutex_);
    tally_ += tally;
  }

  BuildContext& context_;
  const KdSplitter& splitter_;
  const KdCosts costs_;
  const double dear_;  // what a leaf costs that is dear, times the scene's half area
  ProgressMeter& progress_;
  std::mutex mutex_;
  KdTally tally_;
};

// Wald and Havran 2006, section 3.3 "maximum depth", within what traversers have room for.
int most_levels(std::size_t triangles, const BuildOptions& options) {
  const int levels = static_cast<int>(8 + 1.3 * std::log2(static_cast<double>(triangles)));
  return std::min({levels, options.max_depth, kKdStackSize});
}

std::uint64_t most_references(std::size_t triangles, const BuildOptions& options) {
  return static_cast<std::uint64_t>(static_cast<double>(triangles) * options.max_references);
}

// What users may wonder about.
void explain(const KdTally& tally, int levels, BuildReport& report) {
  const auto note = [&](std::uint64_t count, const char* what, const std::string& why) {
    if (count > 0) report.notes.push_back({std::to_string(count) + " " + what, why});
  };
  note(tally.dropped_parts, "parts of triangles", "skipped, because only the triangle's box reaches into the cell");
  note(tally.limited_leaves, "splits", "skipped, because they would make more references than max_references allows");
  note(tally.bottom_leaves, "leaves", "not split further, because they lie " + std::to_string(levels) + " levels deep");
}

}  // namespace

Result<Built<KdTree>> KdTreeSah::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return build(mesh, options, KdCosts::of(options));
}

Result<Built<KdTree>> KdTreeSah::build(const TriangleMesh& mesh, const BuildOptions& options, const KdCosts& costs) {
  return run_build<KdTree>(mesh, options, [&costs](BuildContext& context) -> Result<KdTree> {
    References references = make_references(context, 0);
    if (references.count == 0) return KdTree{};

    context.begin_phase("sort");
    const KdSplitter splitter(context.mesh, references.bounds.boxes.aabb());
    ScratchStack memory(context.memory);
    KdSet root = splitter.root_set(references.storage.data(), references.count, memory);
    root.levels = most_levels(references.count, context.options);
    root.limit = most_references(references.count, context.options);
    context.memory.subtract(references.storage.size_bytes());
    references = {};

    context.begin_phase("split");
    ProgressMeter progress(context.options.progress, "split", root.limit);
    KdTreeBuilder builder(context, splitter, costs, root.cell, progress);
    const std::unique_ptr<KdSubtree> subtree = builder.build(root, std::move(memory));
    if (progress.stopped()) return Error{std::string(kInterrupted)};

    Result<KdTree> tree = emit_kdtree(context, *subtree);
    if (!tree) return tree;
    tree->bounds = root.cell;
    tree->depth = static_cast<std::uint32_t>(root.levels - builder.tally().least_levels);
    explain(builder.tally(), root.levels, context.report);
    return tree;
  });
}

}  // namespace accel
