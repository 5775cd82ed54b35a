#include "apps/common/table.h"

#include <algorithm>

#include "apps/common/terminal.h"

namespace accel::apps {

std::string Table::text() const {
  const std::vector<std::size_t> width = widths();
  std::string text;
  const auto add_line = [&](auto&& cell_of) {
    std::string line;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (width[c] == 0) continue;
      const std::string& cell = cell_of(c);
      const std::string padding(width[c] - visible_width(cell), ' ');
      line += "  " + (columns_[c].align == Align::left ? cell + padding : padding + cell);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  };
  add_line([&](std::size_t c) -> const std::string& { return columns_[c].title; });
  for (const auto& row : rows_) {
    if (row.empty())
      text += '\n';
    else
      add_line([&](std::size_t c) -> const std::string& { return row[c]; });
  }
  return text;
}

std::vector<std::size_t> Table::widths() const {
  std::vector<std::size_t> width(columns_.size(), 0);
  for (const auto& row : rows_) {
    for (std::size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], visible_width(row[c]));
  }
  for (std::size_t c = 0; c < width.size(); ++c) {
    if (width[c] > 0) width[c] = std::max(width[c], visible_width(columns_[c].title));
  }
  return width;
}

}  // namespace accel::apps
