#include "apps/common/html.h"

#include <algorithm>
#include <cstdint>

namespace accel::apps {

namespace {

std::string class_attribute(const std::string& style) { return style.empty() ? "" : " class=\"" + style + "\""; }

std::string cell_html(const HtmlCell& cell) {
  constexpr std::size_t kLong = 40;  // characters that are broken into lines
  if (cell.kind == HtmlCell::Kind::row_head)
    return std::string("<th scope=\"row\"") + (cell.text.size() > kLong ? " class=\"long\">" : ">") + html_escaped(cell.text) +
           "</th>";
  const std::string style =
      cell.kind == HtmlCell::Kind::words ? "words" + (cell.style.empty() ? "" : " " + cell.style) : cell.style;
  return "<td" + class_attribute(style) + cell.attributes + ">" + html_escaped(cell.text) + "</td>";
}

}  // namespace

std::string html_escaped(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string json_in_script(std::string_view json) {
  std::string escaped;
  escaped.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      escaped += "\\u003c";
    else
      escaped += c;
  }
  return escaped;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t have = std::min<std::size_t>(bytes.size() - i, 3);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < have ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= have ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

void HtmlTable::add_row(std::vector<HtmlCell> cells, std::string style) {
  if (groups_.empty()) begin_group({});
  groups_.back().rows.push_back({std::move(cells), std::move(style)});
}

std::vector<bool> HtmlTable::used_columns() const {
  std::vector<bool> used(columns_.size(), false);
  for (const Group& group : groups_)
    for (const Row& row : group.rows)
      for (std::size_t c = 0; c < used.size(); ++c) used[c] = used[c] || !row.cells[c].text.empty();
  return used;
}

std::string HtmlTable::head_html(const std::vector<bool>& used) const {
  std::string html = "<thead><tr>";
  for (std::size_t c = 0; c < columns_.size(); ++c)
    if (used[c])
      html += "<th scope=\"col\"" + class_attribute(columns_[c].is_words ? "words" : "") + ">" +
              html_escaped(columns_[c].head) + "</th>";
  return html + "</tr></thead>\n";
}

std::string HtmlTable::row_html(const Row& row, const std::vector<bool>& used) {
  std::string html = "<tr" + class_attribute(row.style) + ">";
  for (std::size_t c = 0; c < row.cells.size(); ++c)
    if (used[c]) html += cell_html(row.cells[c]);
  return html + "</tr>\n";
}

std::string HtmlTable::html() const {
  const std::vector<bool> used = used_columns();
  std::string html = "<div class=\"table\"><table>\n<caption>" + caption_ + "</caption>\n" + head_html(used);
  for (const Group& group : groups_) {
    html += "<tbody>\n";
    if (!group.head.empty())
      html += "<tr><th scope=\"rowgroup\" colspan=\"" + std::to_string(std::count(used.begin(), used.end(), true)) + "\">" +
              html_escaped(group.head) + "</th></tr>\n";
    for (const Row& row : group.rows) html += row_html(row, used);
    html += "</tbody>\n";
  }
  return html + "</table></div>\n";
}

}  // namespace accel::apps
