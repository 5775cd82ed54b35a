#include "apps/common/terminal.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace accel::apps {

namespace {

const char* escape_of(Style style) {
  switch (style) {
    case Style::plain:
      return "";
    case Style::strong:
      return "\x1b[1m";
    case Style::faint:
      return "\x1b[2m";
    case Style::good:
      return "\x1b[32m";
    case Style::warning:
      return "\x1b[33m";
    case Style::bad:
      return "\x1b[1;31m";
  }
  return "";
}

std::string with_escapes(std::string_view text, Style style, bool color) {
  if (!color || style == Style::plain || text.empty()) return std::string(text);
  return escape_of(style) + std::string(text) + "\x1b[0m";
}

bool wants_color(When color, int descriptor) {
  if (color != When::automatic) return color == When::always;
  const char* no_color = std::getenv("NO_COLOR");
  return isatty(descriptor) != 0 && (no_color == nullptr || *no_color == '\0');
}

}  // namespace

void Terminal::configure(Verbosity verbosity, When color) {
  verbosity_ = verbosity;
  color_out_ = wants_color(color, STDOUT_FILENO);
  color_err_ = wants_color(color, STDERR_FILENO);
}

void Terminal::error(std::string_view message) const { say("error", Style::bad, message); }

void Terminal::warning(std::string_view message) const {
  if (!quiet()) say("warning", Style::warning, message);
}

void Terminal::note(std::string_view message) const {
  if (!quiet()) say("", Style::plain, message);
}

void Terminal::detail(std::string_view message) const {
  if (verbose()) say("", Style::faint, message);
}

std::string Terminal::styled(std::string_view text, Style style) const { return with_escapes(text, style, color_out_); }

Finished Terminal::write(std::string_view text) const {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) return Done{};
  return Failure(ExitStatus::error, std::string("cannot write to standard output: ") + std::strerror(errno));
}

void Terminal::say(std::string_view label, Style style, std::string_view message) const {
  std::string line = program_ + ": ";
  if (!label.empty()) line += with_escapes(std::string(label) + ":", style, color_err_) + " ";
  line += label.empty() ? with_escapes(message, style, color_err_) : std::string(message);
  line += '\n';
  std::fwrite(line.data(), 1, line.size(), stderr);
}

std::size_t visible_width(std::string_view text) {
  std::size_t width = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\x1b')
      i = std::min(text.find('m', i), text.size() - 1);
    else
      width += (static_cast<unsigned char>(text[i]) & 0xc0) != 0x80;  // a byte that continues no UTF-8 character
  }
  return width;
}

}  // namespace accel::apps
