// Adds any of a Bvh2's annotations (structure/bvh2.h).
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/build/bvh2_hash.h"
#include "libaccel/build/bvh2_links.h"
#include "libaccel/build/bvh2_octo.h"
#include "libaccel/build/bvh2_skips.h"

namespace accel {

inline Status add_extras(Bvh2& bvh, Bvh2Extras extras, BuildReport& report) {
  switch (extras) {
    case Bvh2Extras::parents:
      return add_links(bvh, Bvh2Links::parents), Done{};
    case Bvh2Extras::uncles:
      return add_links(bvh, Bvh2Links::uncles), Done{};
    case Bvh2Extras::hash:
      return add_hash(bvh, HashedKeys::looked_up, report);
    case Bvh2Extras::full_hash:
      return add_hash(bvh, HashedKeys::all, report);
    case Bvh2Extras::skips:
      return add_skips(bvh), Done{};
    case Bvh2Extras::octant_skips:
      return add_octant_skips(bvh), Done{};
    case Bvh2Extras::octo:
      return add_octo(bvh);
  }
  return Done{};
}

}  // namespace accel
