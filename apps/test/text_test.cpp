#include "apps/common/text.h"

#include <gtest/gtest.h>

#include <limits>

namespace accel::apps {
namespace {

TEST(Text, CommasStandBetweenThousands) {
  EXPECT_EQ(with_commas(0), "0");
  EXPECT_EQ(with_commas(999), "999");
  EXPECT_EQ(with_commas(1000), "1,000");
  EXPECT_EQ(with_commas(1234567), "1,234,567");
  EXPECT_EQ(with_commas(std::numeric_limits<std::uint64_t>::max()), "18,446,744,073,709,551,615");
}

TEST(Text, ShortNumbersHaveAboutThreeDigits) {
  EXPECT_EQ(short_number(0), "0");
  EXPECT_EQ(short_number(0.0012345), "0.00123");
  EXPECT_EQ(short_number(1.2345), "1.23");
  EXPECT_EQ(short_number(9.999), "10.0");
  EXPECT_EQ(short_number(99.96), "100");
  EXPECT_EQ(short_number(-12.34), "-12.3");
  EXPECT_EQ(short_number(1234.5), "1234");
  EXPECT_EQ(short_number(1.5e9), "1.50e+09");
  EXPECT_EQ(short_number(std::numeric_limits<double>::quiet_NaN()), "-");
  EXPECT_EQ(short_number(std::numeric_limits<double>::infinity()), "inf");
}

TEST(Text, BytesAndSecondsChangeUnits) {
  EXPECT_EQ(bytes_text(1023), "1023 B");
  EXPECT_EQ(bytes_text(1024), "1.00 KiB");
  EXPECT_EQ(bytes_text(std::uint64_t{3} << 30), "3.00 GiB");
  EXPECT_EQ(seconds_text(0.0005), "500 us");
  EXPECT_EQ(seconds_text(0.25), "250 ms");
  EXPECT_EQ(seconds_text(2), "2.00 s");
  EXPECT_EQ(seconds_text(123), "2 min 03 s");
}

TEST(Text, SplitKeepsEmptyPartsAndDropsBlanks) {
  EXPECT_EQ(split("a, b ,c", ','), (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(split("", ','), (std::vector<std::string>{""}));
  EXPECT_EQ(split(" , x,", ','), (std::vector<std::string>{"", "x", ""}));
}

TEST(Text, JoinAndCount) {
  EXPECT_EQ(join({"a", "b"}, ", "), "a, b");
  EXPECT_EQ(join({}, ", "), "");
  EXPECT_EQ(counted(1, "ray"), "1 ray");
  EXPECT_EQ(counted(1000, "ray"), "1,000 rays");
}

TEST(Text, ClipsBetweenCharacters) {
  EXPECT_EQ(clipped("hall.ply", 4), "hall");
  EXPECT_EQ(clipped("hall.ply", 8), "hall.ply");
  EXPECT_EQ(clipped("hall.ply", 100), "hall.ply");
  EXPECT_EQ(clipped("B\xc3\xbcro", 2), "B\xc3\xbc");
  EXPECT_EQ(clipped("B\xc3\xbcro", 1), "B");
  EXPECT_EQ(clipped("", 0), "");
}

TEST(Text, WrapsAtSpaces) {
  EXPECT_EQ(wrapped("one two three", 9, "  "), "  one two\n  three\n");
  EXPECT_EQ(wrapped("one two three", 100, ""), "one two three\n");
  EXPECT_EQ(wrapped("a-word-that-is-too-long for it", 8, ""), "a-word-that-is-too-long\nfor it\n");
  EXPECT_EQ(wrapped("", 8, "  "), "");
}

}  // namespace
}  // namespace accel::apps
