// Adds any of a kd-tree's optional arrays (structure/kdtree.h).
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/build/kdtree_links.h"
#include "libaccel/build/kdtree_ropes.h"

namespace accel {

inline Status add_extras(KdTree& tree, KdExtras extras, BuildReport&) {
  switch (extras) {
    case KdExtras::parents_and_boxes:
      return add_links(tree), Done{};
    case KdExtras::ropes:
      return add_ropes(tree), Done{};
  }
  return Done{};
}

}  // namespace accel
