// Numbers and words as people read them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace accel::apps {

// As printf.
[[gnu::format(printf, 1, 2)]] std::string print(const char* format, ...);

// 1234567 -> "1,234,567".
std::string with_commas(std::uint64_t value);

// Three to four digits: 0.00123, 1.23, 12.3, 123, 1235; "-" for NaN.
std::string short_number(double value);

// "850 B", "12.3 KiB", "1.46 GiB".
std::string bytes_text(std::uint64_t bytes);

// "850 us", "12.3 ms", "1.46 s", "2 min 03 s".
std::string seconds_text(double seconds);

// "1 ray", "2 rays".
std::string counted(std::uint64_t count, std::string_view noun);

// What goes on about counted things: "it has", "they have".
std::string it_has(std::uint64_t count);

// The text in lines of at most `width` columns, broken at spaces, each indented and ended.
std::string wrapped(std::string_view text, std::size_t width, std::string_view indent);

// Its beginning, of so many characters of UTF-8 at most.
std::string clipped(std::string_view text, std::size_t characters);

// The parts of `text` between separators, without white space at their ends. Empty parts are kept.
std::vector<std::string> split(std::string_view text, char separator);

std::string join(const std::vector<std::string>& parts, std::string_view separator);

}  // namespace accel::apps
