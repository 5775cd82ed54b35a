// How long frustums take through trees, for gl10. Depth first must find what breadth first finds.
#include "bench/paper_tables/gl10.h"
#include "libaccel/packet/depth_first.h"
#include "libaccel/packet/serial_primitives.h"

namespace accel::paper_tables::garanzha_loop {

namespace {

class Walks {
 public:
  Walks(const Bvh2View& view, const std::vector<Frustum>& frustums) : view_(view), frustums_(frustums) {
    budgets_.assign(frustums.size(), PipelineOptions{}.budget), gave_up_.resize(frustums.size());
    result_.frustums = frustums.size();
  }

  Result<WalkTimes> measure(int repeat) {
    for (int turn = -1; turn < repeat; ++turn) {
      if (const Status s = take_turn(); !s) return s.error();
      if (turn >= 0) continue;
      for (auto& t : times_) t.clear();
    }
    for (int w = 0; w < kWalks; ++w) result_.ms[w] = median(times_[w]);
    return result_;
  }

 private:
  Status take_turn() {
    Status s = pair(octo_, octo_depth_, kOcto, result_.leaves);
    if (s) s = pair(octo_scalar_, octo_scalar_depth_, kOctoScalar, result_.leaves);
    if (s) s = pair(binary_, binary_depth_, kBinary, result_.binary_leaves);
    return s;
  }

  // A walk breadth first, and the next one, which is the same depth first.
  template <class Broad, class Deep>
  Status pair(Broad& broad, Deep& deep, Walk walk, std::size_t& leaves) {
    const typename Broad::Queue* queue = nullptr;
    const auto run_broad = [&] {
      queue = &broad.run(view_, frustums_.data(), frustums_.size(), budgets_.data(), gave_up_.data());
      return Status(Done{});
    };
    const typename Deep::Leaves* found = nullptr;
    const auto run_deep = [&] { return found = &deep.run(view_, frustums_.data(), frustums_.size()), Status(Done{}); };
    if (const Status s = time_ms(run_broad, times_[walk]); !s) return s;
    if (const Status s = time_ms(run_deep, times_[walk + 1]); !s) return s;
    leaves = queue->count;
    const bool agree =
        std::equal(found->place.begin(), found->place.end(), queue->place.data(), queue->place.data() + leaves) &&
        std::equal(found->frustum.begin(), found->frustum.end(), queue->frustum.data());
    return agree ? Status(Done{}) : Error{"depth-first traversal finds other leaves, which is a bug"};
  }

  const Bvh2View view_;
  const std::vector<Frustum>& frustums_;
  std::vector<std::uint32_t> budgets_;
  std::vector<std::uint8_t> gave_up_;
  std::vector<double> times_[kWalks];
  WalkTimes result_;
  BreadthFirst<SerialPrimitives, SimdCulling> octo_;
  BreadthFirst<SerialPrimitives, ScalarCulling> octo_scalar_;
  BreadthFirst<SerialPrimitives, ScalarCullingOf<BinaryTree>, BinaryTree> binary_;
  DepthFirst<OctoTree, SimdChildren> octo_depth_;
  DepthFirst<OctoTree, ScalarChildren<OctoTree>> octo_scalar_depth_;
  DepthFirst<BinaryTree, ScalarChildren<BinaryTree>> binary_depth_;
};

}  // namespace

Result<WalkTimes> measure_walks(const Bvh2View& view, const std::vector<Frustum>& frustums, const Settings& settings) {
  return Walks(view, frustums).measure(settings.repeat);
}

}  // namespace accel::paper_tables::garanzha_loop
