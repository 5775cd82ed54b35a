#include "libaccel/build/kdtree_sah.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include <tbb/task_group.h>

#include "libaccel/build/emit_kdtree.h"
#include "libaccel/build/kdtree_plane.h"
#include "libaccel/build/kdtree_split.h"

namespace accel {
namespace {

// Sets above this are split one by one, their children in concurrent tasks; a smaller set becomes a treelet, built by one task.
constexpr std::size_t kKdTaskSize = 8192;

class KdTreeBuilder {
 public:
  KdTreeBuilder(BuildContext& context, const KdSplitter& splitter, const KdCosts& costs, ProgressMeter& progress)
      : context_(context), splitter_(splitter), costs_(costs), progress_(progress) {}

  // The tree over a set that lies in `memory`. When progress says stop, what is left is put into leaves.
  std::unique_ptr<KdSubtree> build(const KdSet& set, ScratchStack memory) {
    auto tree = std::make_unique<KdSubtree>();
    if (set.size <= kKdTaskSize) {
      build_treelet(set, memory, tree->treelet);
      return tree;
    }
    const KdPlane plane = choose_plane(set);
    if (!plane.found()) {
      build_treelet(set, memory, tree->treelet);
      return tree;
    }
    KdSet children[2];
    ScratchStack lower(context_.memory), upper(context_.memory);
    {
      ScratchStack own = std::move(memory);
      splitter_.split(set, plane, own, lower, upper, children);
    }
    tree->axis = plane.axis, tree->position = plane.position;
    tbb::task_group group;
    group.run([&] { tree->child[1] = build(children[1], std::move(upper)); });
    tree->child[0] = build(children[0], std::move(lower));
    group.wait();
    return tree;
  }

  // The fewest levels that any leaf had left.
  int least_levels() const { return least_levels_.load(); }

 private:
  void build_treelet(const KdSet& set, ScratchStack& memory, KdTreelet& treelet) {
    ScratchStack scratch(context_.memory);
    int least_levels = set.levels;
    treelet.root = build_node(set, memory, scratch, treelet, least_levels);
    context_.memory.add(treelet.size_bytes());
    progress_.advance(set.limit);
    for (int seen = least_levels_.load(); least_levels < seen && !least_levels_.compare_exchange_weak(seen, least_levels);) {
    }
  }

  KdNode build_node(const KdSet& set, ScratchStack& memory, ScratchStack& scratch, KdTreelet& treelet, int& least_levels) {
    const KdPlane plane = choose_plane(set);
    if (!plane.found()) {
      least_levels = std::min(least_levels, set.levels);
      return build_leaf(set, treelet);
    }
    const ScratchStack::Mark mark = memory.mark();
    KdSet children[2];
    splitter_.split(set, plane, scratch, memory, memory, children);
    const std::size_t pair = treelet.nodes.size();
    treelet.nodes.resize(pair + 2);
    for (int c = 0; c < 2; ++c) {
      const KdNode child = build_node(children[c], memory, scratch, treelet, least_levels);
      treelet.nodes[pair + c] = child;
    }
    memory.release(mark);
    return KdNode::inner(plane.axis, plane.position, static_cast<std::uint32_t>(pair));
  }

  static KdNode build_leaf(const KdSet& set, KdTreelet& treelet) {
    const KdNode leaf = treelet.add_leaf(set.size);
    for (std::uint32_t i = 0; i < set.size; ++i) treelet.references.push_back(set.references[i].prim_id);
    if (set.size > 0) treelet.references.back() |= kLastReference;
    return leaf;
  }

  // The cheapest plane, if the set is better split there than left whole.
  KdPlane choose_plane(const KdSet& set) const {
    if (set.size == 0 || set.levels == 0 || progress_.stopped()) return {};
    const KdPlane plane = cheapest_plane(set, costs_);
    return plane.cost < costs_.intersection * half_area_in_double(set.cell) * set.size ? plane : KdPlane{};
  }

  BuildContext& context_;
  const KdSplitter& splitter_;
  const KdCosts costs_;
  ProgressMeter& progress_;
  std::atomic<int> least_levels_{kMaxBuildDepth};
};

// Wald and Havran 2006, section 3.3 "maximum depth", within what traversers have room for.
int most_levels(std::size_t triangles, const BuildOptions& options) {
  const int levels = static_cast<int>(8 + 1.3 * std::log2(static_cast<double>(triangles)));
  return std::min({levels, options.max_depth, kKdStackSize});
}

std::uint64_t most_references(std::size_t triangles, const BuildOptions& options) {
  return static_cast<std::uint64_t>(static_cast<double>(triangles) * options.max_references);
}

KdCosts costs_of(const BuildOptions& options) {
  return {options.traversal_cost, options.intersection_cost, options.empty_bonus};
}

}  // namespace

Result<Built<KdTree>> KdTreeSah::build(const TriangleMesh& mesh, const BuildOptions& options) {
  return run_build<KdTree>(mesh, options, [](BuildContext& context) -> Result<KdTree> {
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
    KdTreeBuilder builder(context, splitter, costs_of(context.options), progress);
    const std::unique_ptr<KdSubtree> subtree = builder.build(root, std::move(memory));
    if (progress.stopped()) return Error{std::string(kInterrupted)};

    Result<KdTree> tree = emit_kdtree(context, *subtree);
    if (!tree) return tree;
    tree->bounds = root.cell;
    tree->depth = static_cast<std::uint32_t>(root.levels - builder.least_levels());
    return tree;
  });
}

}  // namespace accel
