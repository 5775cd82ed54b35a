#include "apps/common/text.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace accel::apps {

std::string print(const char* format, ...) {
  va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, arguments);
  va_end(arguments);
  std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
  if (length > 0) std::vsnprintf(text.data(), text.size() + 1, format, again);
  va_end(again);
  return text;
}

std::string with_commas(std::uint64_t value) {
  std::string text = std::to_string(value);
  for (std::size_t place = text.size(); place > 3; place -= 3) text.insert(place - 3, 1, ',');
  return text;
}

std::string short_number(double value) {
  if (std::isnan(value)) return "-";
  const double size = std::abs(value);
  if (size == 0) return "0";
  if (size >= 1e7 || size < 1e-4) return print("%.2e", value);
  if (size >= 99.95) return print("%.0f", value);
  if (size >= 9.995) return print("%.1f", value);
  if (size >= 0.0995) return print("%.2f", value);
  return print("%.3g", value);
}

std::string bytes_text(std::uint64_t bytes) {
  if (bytes < 1024) return std::to_string(bytes) + " B";
  const char* const units[] = {"KiB", "MiB", "GiB", "TiB", "PiB"};
  double value = static_cast<double>(bytes) / 1024;
  int unit = 0;
  for (; value >= 999.5 && unit < 4; ++unit) value /= 1024;
  return short_number(value) + " " + units[unit];
}

std::string seconds_text(double seconds) {
  if (seconds < 1e-3) return print("%.0f us", seconds * 1e6);
  if (seconds < 0.9995) return short_number(seconds * 1e3) + " ms";
  if (seconds < 99.5) return short_number(seconds) + " s";
  const auto whole = static_cast<std::uint64_t>(std::llround(seconds));
  return print("%llu min %02llu s", static_cast<unsigned long long>(whole / 60), static_cast<unsigned long long>(whole % 60));
}

std::string counted(std::uint64_t count, std::string_view noun) {
  return with_commas(count) + " " + std::string(noun) + (count == 1 ? "" : "s");
}

std::string it_has(std::uint64_t count) { return count == 1 ? "it has" : "they have"; }

std::string wrapped(std::string_view text, std::size_t width, std::string_view indent) {
  std::string lines, line;
  for (const std::string& word : split(text, ' ')) {
    if (!line.empty() && indent.size() + line.size() + 1 + word.size() > width) {
      lines += std::string(indent) + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return line.empty() ? lines : lines + std::string(indent) + line + "\n";
}

std::string clipped(std::string_view text, std::size_t characters) {
  std::size_t end = 0;
  for (; end < text.size(); ++end) {
    const bool begins = (static_cast<unsigned char>(text[end]) & 0xc0u) != 0x80u;
    if (begins && characters-- == 0) break;
  }
  return std::string(text.substr(0, end));
}

std::vector<std::string> split(std::string_view text, char separator) {
  constexpr std::string_view kSpace = " \t\r\n";
  std::vector<std::string> parts;
  while (true) {
    const std::size_t end = text.find(separator);
    std::string_view part = text.substr(0, end);
    part.remove_prefix(std::min(part.find_first_not_of(kSpace), part.size()));
    part.remove_suffix(part.size() - (part.find_last_not_of(kSpace) + 1));
    parts.emplace_back(part);
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::string join(const std::vector<std::string>& parts, std::string_view separator) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : std::string(separator)) + part;
  return text;
}

}  // namespace accel::apps
