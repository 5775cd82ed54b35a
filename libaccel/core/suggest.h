// "Did you mean": the known name that is closest to a mistyped one.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "libaccel/core/result.h"

namespace accel {

// Edits (insert, delete, replace, swap neighbours; letters compared without case) that turn `a` into `b`. O(|a| |b|).
int edit_distance(std::string_view a, std::string_view b);

// The candidate that `name` is most likely a slip of: the first with the fewest edits, or one that it begins. Nothing when even
// the closest differs in more than a third of its letters.
std::optional<std::string_view> closest_match(std::string_view name, std::span<const std::string_view> candidates);

// "unknown scene 'stadum'; did you mean 'stadium'?", or the list of all candidates where none is close.
Error unknown_name(std::string_view what, std::string_view name, std::span<const std::string_view> candidates);

}  // namespace accel
