#include "libaccel/core/suggest.h"

#include <algorithm>
#include <string>
#include <vector>

namespace accel {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool same(char a, char b) { return lower(a) == lower(b); }

// Whether `candidate` starts with `name`.
bool begins(std::string_view name, std::string_view candidate) {
  return !name.empty() && name.size() <= candidate.size() && std::equal(name.begin(), name.end(), candidate.begin(), same);
}

}  // namespace

int edit_distance(std::string_view a, std::string_view b) {
  // Rows of the table of optimal string alignment: the one before the last, the last, and the one being filled.
  const std::size_t columns = b.size() + 1;
  std::vector<int> before(columns), last(columns), row(columns);
  for (std::size_t j = 0; j < columns; ++j) last[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j < columns; ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same(a[i - 1], b[j - 1]) ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]);
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

std::optional<std::string_view> closest_match(std::string_view name, std::span<const std::string_view> candidates) {
  std::optional<std::string_view> best;
  int best_distance = 0;
  for (const std::string_view candidate : candidates) {
    if (begins(name, candidate)) return candidate;
    const int distance = edit_distance(name, candidate);
    const int limit = std::max<int>(1, static_cast<int>(std::max(name.size(), candidate.size()) / 3));
    if (distance > limit || (best && distance >= best_distance)) continue;
    best = candidate, best_distance = distance;
  }
  return best;
}

Error unknown_name(std::string_view what, std::string_view name, std::span<const std::string_view> candidates) {
  std::string message = "unknown " + std::string(what) + " '" + std::string(name) + "'; ";
  if (const auto match = closest_match(name, candidates)) return Error{message + "did you mean '" + std::string(*match) + "'?"};
  message += "known are";
  for (std::size_t i = 0; i < candidates.size(); ++i) message += (i == 0 ? " " : ", ") + std::string(candidates[i]);
  return Error{message};
}

}  // namespace accel
