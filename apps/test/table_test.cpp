#include "apps/common/table.h"

#include <gtest/gtest.h>

#include "apps/common/terminal.h"

namespace accel::apps {
namespace {

using Align = Table::Align;

TEST(Table, ColumnsAreAsWideAsTheirWidestCell) {
  Table table({{"NAME", Align::left}, {"count"}});
  table.add_row({"a", "12345"});
  table.add_row({"longer", "6"});
  EXPECT_EQ(table.text(), "  NAME    count\n  a       12345\n  longer      6\n");
}

TEST(Table, ColumnsWithoutTextAreLeftOut) {
  Table table({{"NAME", Align::left}, {"nothing"}, {"count"}});
  table.add_row({"a", "", "1"});
  EXPECT_EQ(table.text(), "  NAME  count\n  a         1\n");
}

TEST(Table, LinesHaveNoBlanksAtTheirEnds) {
  Table table({{"NAME", Align::left}, {"", Align::left}});
  table.add_row({"a", "x"});
  table.add_row({"b", ""});
  EXPECT_EQ(table.text(), "  NAME\n  a     x\n  b\n");
}

TEST(Table, EscapesAndContinuationBytesTakeNoColumns) {
  EXPECT_EQ(visible_width("\x1b[1;31mab\x1b[0m"), 2u);
  EXPECT_EQ(visible_width("\xc3\xa9t\xc3\xa9"), 3u);  // été
  EXPECT_EQ(visible_width("\x1b["), 0u);              // cut short
  Table table({{"N"}, {"M"}});
  table.add_row({"\x1b[1m1\x1b[0m", "2"});
  EXPECT_EQ(table.text(), "  N  M\n  \x1b[1m1\x1b[0m  2\n");
}

}  // namespace
}  // namespace accel::apps
