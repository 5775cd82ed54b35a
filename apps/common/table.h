// A table of text: columns as wide as their widest cell.
#pragma once

#include <string>
#include <vector>

namespace accel::apps {

// The widest that the programs' tables may be, in columns.
inline constexpr std::size_t kTableWidth = 100;

class Table {
 public:
  enum class Align { left, right };
  struct Column {
    std::string title;
    Align align = Align::right;
  };

  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  // One cell a column. Cells may hold the escapes of Terminal::styled().
  void add_row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

  // A thin gap before the next row.
  void add_gap() { rows_.emplace_back(); }

  // The lines, indented by two spaces, with no white space at their ends. Columns without any text are left out.
  std::string text() const;

 private:
  std::vector<std::size_t> widths() const;

  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace accel::apps
