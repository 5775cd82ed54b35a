#include "libaccel/build/reinsertion.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include "libaccel/build/parallel.h"
#include "libaccel/build/reinsertion_search.h"
#include "libaccel/build/reinsertion_tree.h"

namespace accel {
namespace {

// Inner nodes whose children one task searches places for.
constexpr std::uint32_t kNodesPerTask = 256;

template <class T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

class Rounds {
 public:
  Rounds(BuildContext& context, Bvh2& bvh)
      : context_(context),
        options_(context.options),
        root_area_(half_area_in_double(bvh.bounds)),
        tree_(bvh, static_cast<std::uint32_t>(std::min(options_.max_depth, kBvh2StackSize))) {
    context_.memory.add(tree_.size_bytes());
  }

  Status run() {
    for (double gain = kLeastRoundGain; may_go_on(gain); ++rounds_) {
      const double before = cost(tree_.inner_area());
      if (Status done = round(); !done) return done;
      gain = 1 - cost(tree_.inner_area()) / before;
      if (gain < kGainOfSameShare && share_ > 1) share_ /= 2;
    }
    return Done{};
  }

  void give_back(Bvh2& bvh) {
    const std::size_t again = tree_.node_count() * sizeof(Bvh2Node) + bvh.leaves.size_bytes();
    context_.memory.add(again);
    tree_.give_back(bvh);
    context_.memory.subtract(again + tree_.size_bytes());
  }

  BuildNote note() const {
    char costs[80];
    std::snprintf(costs, sizeof costs, "SAH cost %.4g to %.4g", cost(tree_.inner_area_before()), cost(tree_.inner_area()));
    return {"reinsertion", "optimized in " + std::to_string(rounds_) + (rounds_ == 1 ? " round: " : " rounds: ") +
                               std::to_string(moves_) + " nodes moved, " + costs + "; ended because " + why_};
  }

 private:
  double cost(double inner_area) const {
    const double sum = options_.traversal_cost * inner_area + options_.intersection_cost * tree_.leaf_area();
    return root_area_ > 0 ? sum / root_area_ : 0;
  }

  // `gain` is that of the last round. NaN, of a tree without cost, is none.
  bool may_go_on(double gain) {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
    if (!(gain >= kLeastRoundGain))
      why_ = "the last gained little";
    else if (rounds_ == options_.reinsertion_rounds)
      why_ = "no more were asked for";
    else if (options_.reinsertion_seconds > 0 && passed.count() >= static_cast<double>(options_.reinsertion_seconds))
      why_ = "time was up";
    return why_.empty();
  }

  Status round() {
    ProgressMeter progress(options_.progress, "reinsertion", tree_.node_count());
    std::vector<Reinsertion> found = search(progress);
    if (progress.stopped()) return Error{std::string(kInterrupted)};
    tbb::parallel_sort(found.begin(), found.end(), [](const Reinsertion& a, const Reinsertion& b) {
      return a.gain != b.gain ? a.gain > b.gain : a.subtree < b.subtree;
    });
    for (const Reinsertion& one : found) moves_ += tree_.improve(one.subtree, one.target) ? 1 : 0;
    return Done{};
  }

  // Places of this round's subtrees, as far as they gain.
  std::vector<Reinsertion> search(ProgressMeter& progress) {
    std::vector<float> prospects(2 * std::size_t{tree_.node_count()});
    for_chunks(0, prospects.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t slot = begin; slot < end; ++slot) prospects[slot] = prospect(static_cast<ReinsertionTree::Slot>(slot));
    });
    const float least = least_of_share(prospects);

    std::vector<std::vector<Reinsertion>> parts((tree_.node_count() + kNodesPerTask - 1) / kNodesPerTask);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
      if (progress.stopped()) return;
      ReinsertionSearch search(tree_);
      const std::size_t begin = 2 * part * kNodesPerTask, end = std::min(begin + 2 * kNodesPerTask, prospects.size());
      for (std::size_t slot = begin; slot < end; ++slot) {
        if (!(prospects[slot] >= least)) continue;
        const Reinsertion best = search.best_place(tree_.ref_at(static_cast<ReinsertionTree::Slot>(slot)));
        if (best.gain > 0) parts[part].push_back(best);
      }
      progress.advance((end - begin) / 2);
    });

    std::vector<Reinsertion> all;
    std::size_t bytes = 2 * bytes_of(prospects);  // one to find the least in
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end()), bytes += bytes_of(part);
    bytes += bytes_of(all);
    context_.memory.add(bytes), context_.memory.subtract(bytes);
    return all;
  }

  // What a subtree gains at its parent when it goes, less what it costs anywhere. Never NaN, which infinite areas would make.
  float prospect(ReinsertionTree::Slot slot) const {
    const float gain = tree_.box_at(tree_.slot_of(slot / 2)).half_area() - tree_.box_at(slot).half_area();
    return gain > 0 ? gain : 0;
  }

  // The least prospect of this round's share.
  float least_of_share(std::vector<float> prospects) const {
    if (share_ == 1) return -std::numeric_limits<float>::infinity();
    const auto last = prospects.begin() + static_cast<std::ptrdiff_t>(prospects.size() / share_);
    std::nth_element(prospects.begin(), last, prospects.end(), std::greater<float>());
    return *last;
  }

  BuildContext& context_;
  const BuildOptions& options_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  const double root_area_;
  ReinsertionTree tree_;
  std::size_t share_ = kFirstShare;  // one in so many subtrees
  int rounds_ = 0;
  std::size_t moves_ = 0;
  std::string why_;
};

}  // namespace

Status reinsert(BuildContext& context, Bvh2& bvh) {
  if (context.options.reinsertion_rounds == 0 || bvh.nodes.empty()) return Done{};
  context.begin_phase("reinsertion");
  Rounds rounds(context, bvh);
  if (Status done = rounds.run(); !done) return done;
  rounds.give_back(bvh);
  context.report.notes.push_back(rounds.note());
  return Done{};
}

}  // namespace accel
