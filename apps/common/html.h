// Text that goes into pages: nothing from outside may be read as markup.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace accel::apps {

// For text and for attributes in double quotes.
std::string html_escaped(std::string_view text);

// JSON for a <script> element, which no string in it can end: "<" is written as an escape, and means the same.
std::string json_in_script(std::string_view json);

std::string base64(std::string_view bytes);

// What a cell of a table shows.
struct HtmlCell {
  enum class Kind { words, number, row_head };

  std::string text;  // plain: it is escaped on its way into the page
  Kind kind = Kind::words;
  std::string attributes;  // markup: where the number comes from
  std::string style;       // a class of report.css, or empty
};

// A table with a caption. Columns that are empty in every row are left out.
class HtmlTable {
 public:
  struct Column {
    std::string head;
    bool is_words = false;  // flush left
  };

  // The caption is markup.
  HtmlTable(std::string caption, std::vector<Column> columns) : caption_(std::move(caption)), columns_(std::move(columns)) {}

  // The rows from here on belong together.
  void begin_group(std::string head) { groups_.push_back({std::move(head), {}}); }
  // One cell a column; `style` is the row's class.
  void add_row(std::vector<HtmlCell> cells, std::string style = {});

  bool empty() const { return groups_.empty(); }
  std::string html() const;

 private:
  struct Row {
    std::vector<HtmlCell> cells;
    std::string style;
  };
  struct Group {
    std::string head;
    std::vector<Row> rows;
  };

  std::vector<bool> used_columns() const;
  std::string head_html(const std::vector<bool>& used) const;
  static std::string row_html(const Row& row, const std::vector<bool>& used);

  std::string caption_;
  std::vector<Column> columns_;
  std::vector<Group> groups_;
};

}  // namespace accel::apps
