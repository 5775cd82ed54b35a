#include "libaccel/build/kdtree_layout.h"

#include <algorithm>

#include "libaccel/build/kdtree_walk.h"

namespace accel {
namespace {

constexpr std::uint64_t kPairsPerLine = 64 / (2 * sizeof(KdNode));

// An inner node whose pair of children has no place yet.
struct Waiting {
  KdNode node;
  Aabb cell;
  double area;

  Waiting() = default;
  Waiting(KdNode inner, const Aabb& inner_cell) : node(inner), cell(inner_cell), area(half_area_in_double(inner_cell)) {}
};
bool is_smaller(const Waiting& a, const Waiting& b) { return a.area < b.area; }

class PairLayout {
 public:
  PairLayout(const std::vector<KdNode>& nodes, std::uint64_t first_pair)
      : nodes_(nodes), first_pair_(first_pair), places_(nodes.size() / 2) {}

  std::vector<std::uint32_t> run(KdNode root, const Aabb& cell) {
    if (!root.is_leaf()) waiting_.emplace_back(root, cell);
    while (!waiting_.empty()) {
      const Waiting next = waiting_.back();
      waiting_.pop_back();
      fill_line(next);
    }
    return std::move(places_);
  }

 private:
  // Fills what is left of the current line with pairs at and below `first`; those that find no room wait.
  void fill_line(const Waiting& first) {
    Waiting below[kPairsPerLine + 1] = {first};
    std::size_t size = 1;
    for (std::uint64_t room = kPairsPerLine - (first_pair_ + placed_) % kPairsPerLine; room > 0 && size > 0; --room) {
      Waiting* const likeliest = std::max_element(below, below + size, is_smaller);
      const Waiting next = *likeliest;
      *likeliest = below[--size];
      places_[pair_of(next.node.lower_child())] = placed_++;
      for (std::uint32_t side = 0; side < 2; ++side) {
        const KdNode child = nodes_[next.node.lower_child() + side];
        if (!child.is_leaf()) below[size++] = Waiting(child, part_of(next.cell, next.node, side));
      }
    }
    const auto others = static_cast<std::ptrdiff_t>(waiting_.size());
    for (std::size_t i = 0; i < size; ++i)
      waiting_.insert(std::upper_bound(waiting_.begin() + others, waiting_.end(), below[i], is_smaller), below[i]);
  }

  const std::vector<KdNode>& nodes_;
  const std::uint64_t first_pair_;
  std::vector<std::uint32_t> places_;
  std::uint32_t placed_ = 0;
  std::vector<Waiting> waiting_;
};

}  // namespace

std::vector<std::uint32_t> clustered_pairs(const std::vector<KdNode>& nodes, KdNode root, const Aabb& cell,
                                           std::uint64_t first_pair) {
  return PairLayout(nodes, first_pair).run(root, cell);
}

}  // namespace accel
