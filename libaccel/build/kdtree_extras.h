// Adds any of a kd-tree's optional arrays (structure/kdtree.h).
#pragma once

#include "libaccel/build/kdtree_links.h"
#include "libaccel/build/kdtree_ropes.h"

namespace accel {

inline void add_extras(KdTree& tree, KdExtras extras) {
  switch (extras) {
    case KdExtras::parents_and_boxes:
      return add_links(tree);
    case KdExtras::ropes:
      return add_ropes(tree);
  }
}

}  // namespace accel
