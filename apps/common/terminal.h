// What the programs say: results on standard output, everything else on standard error.
#pragma once

#include <string>
#include <string_view>

#include "apps/common/failure.h"

namespace accel::apps {

enum class When { automatic, always, never };

enum class Verbosity { quiet, normal, verbose };

// Text in a colour that says what it means. The escapes are added only where colour is on.
enum class Style { plain, strong, faint, good, warning, bad };

class Terminal {
 public:
  explicit Terminal(std::string program) : program_(std::move(program)) {}

  // Decides on colour: automatic means that the stream is a terminal and NO_COLOR is not set.
  void configure(Verbosity verbosity, When color);

  const std::string& program() const { return program_; }
  bool verbose() const { return verbosity_ == Verbosity::verbose; }
  bool quiet() const { return verbosity_ == Verbosity::quiet; }

  // "PROGRAM: error: MESSAGE" and so on, on standard error. note() is silent when quiet, detail() speaks only when verbose.
  void error(std::string_view message) const;
  void warning(std::string_view message) const;
  void note(std::string_view message) const;
  void detail(std::string_view message) const;

  // The text with the escapes of a style, for standard output.
  std::string styled(std::string_view text, Style style) const;

  // Writes results to standard output. Fails where it cannot be written: a full disk, a closed pipe.
  Finished write(std::string_view text) const;

 private:
  void say(std::string_view label, Style style, std::string_view message) const;

  std::string program_;
  Verbosity verbosity_ = Verbosity::normal;
  bool color_out_ = false, color_err_ = false;
};

// The number of columns that a style's escapes do not take.
std::size_t visible_width(std::string_view text);

}  // namespace accel::apps
