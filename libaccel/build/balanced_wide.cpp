#include "libaccel/build/balanced_wide.h"

#include <algorithm>

#include "libaccel/build/wide_node.h"

namespace accel {
namespace {

class Balanced {
 public:
  Balanced(const Buffer<Reference>& sorted, const BuildOptions& options, std::vector<BlockRun>& runs)
      : sorted_(sorted),
        runs_(runs),
        max_depth_(static_cast<std::uint32_t>(options.max_depth)),
        leaf_size_(static_cast<std::size_t>(options.max_leaf_size)) {}

  WideNodes run() {
    const NodeRef root = build(0, sorted_.size(), 0).ref;
    return {Buffer<Bvh8Node>::copy_of(nodes_), root, depth_};
  }

 private:
  // As deep as the logarithm of the size.
  WideChild build(std::size_t begin, std::size_t end, std::uint32_t above) {
    depth_ = std::max(depth_, above);
    if (above == max_depth_ || end - begin <= leaf_size_) return make_leaf(begin, end);
    const std::size_t index = nodes_.size(), size = end - begin;
    nodes_.emplace_back();
    WideChild children[kBvh8Arity];
    Box4 box;
    const auto count = static_cast<std::uint32_t>(std::min<std::size_t>(size, kBvh8Arity));
    for (std::uint32_t c = 0; c < count; ++c) {
      children[c] = build(begin + size * c / count, begin + size * (c + 1) / count, above + 1);
      box.extend(children[c].box);
    }
    make_wide_node(children, count, nodes_[index]);
    return {static_cast<NodeRef>(index), box};
  }

  WideChild make_leaf(std::size_t begin, std::size_t end) {
    const auto first_block = static_cast<std::uint32_t>(runs_.size());
    for (std::size_t i = begin; i < end; i += kBlockLanes)
      runs_.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(std::min<std::size_t>(end - i, kBlockLanes))});
    const auto blocks = static_cast<std::uint32_t>(runs_.size()) - first_block;
    if (blocks > kMostCounted) runs_.push_back({0, 0});
    return {block_ref(first_block & (kMaxBlocks - 1), blocks), bounds_of(sorted_.data(), begin, end).boxes};
  }

  const Buffer<Reference>& sorted_;
  std::vector<BlockRun>& runs_;
  const std::uint32_t max_depth_;
  const std::size_t leaf_size_;
  std::vector<Bvh8Node> nodes_;
  std::uint32_t depth_ = 0;
};

}  // namespace

WideNodes balanced_wide(const Buffer<Reference>& sorted, const BuildOptions& options, std::vector<BlockRun>& runs) {
  return Balanced(sorted, options, runs).run();
}

}  // namespace accel
