// What the command lines of all programs share: option types, checks of values, errors that name the flag and suggest another.
//
// Included by the option parsers alone: CLI11 is slow to compile.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <string>

#include "apps/common/common_settings.h"
#include "libaccel/build/builder.h"

namespace accel::apps {

// A whole number in [least, most].
CLI::Validator whole_number(std::uint64_t least, std::uint64_t most = std::numeric_limits<std::int64_t>::max());

// A finite number in [least, most]; NaN is none.
CLI::Validator real_number(double least, double most);

// --threads --seed --quiet --verbose --progress --color, and --help and --version, which end the parsing.
void add_common_options(CLI::App& app, CommonSettings& settings);

// The cost model and limits of builders.
void add_build_options(CLI::App& app, BuildOptions& options);

// Parses; the text is what --help or --version asked for, else empty. All errors are usage errors.
Outcome<std::string> parse_arguments(CLI::App& app, int argc, char** argv, CommonSettings& settings);

}  // namespace accel::apps
