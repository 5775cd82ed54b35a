// The tables of the papers, ours beside the paper's.
//
// --help says what it takes. Tables go to stdout, messages to stderr; the JSON has Google Benchmark's shape.
//
// Exit status: 0 ok, 1 error, 2 usage.
#include <charconv>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <span>
#include <string_view>

#include "bench/paper_tables/paper_tables.h"
#include "libaccel/core/suggest.h"
#include "libaccel/core/version.h"

namespace accel::paper_tables {
namespace {

constexpr const char* kHelp =
    R"(paper_tables [PAPER]... [--scenes DIR] [--size N] [--repeat N] [--threads N] [--json FILE|-]

Prints the tables of papers, ours beside the paper's. PAPER is
  fs05  Foley and Sugerman 2005: kd-trees
  gl10  Garanzha and Loop 2010: ray sorting and packets
  bk16  Binder and Keller 2016: backtracking by hash
and without one, all of them.

  --scenes DIR   holds the papers' scenes (../shared/scenes); built-in ones of comparable kind stand in for missing ones
  --size N       pixels of a picture's side
  --repeat N     of everything that is timed; medians count
  --threads N    of all methods
  --json FILE|-  all figures, too
)";

struct Paper {
  std::string_view name;
  Result<Report> (*make)(const Settings&);
};
constexpr Paper kPapers[] = {{"fs05", fs05}, {"gl10", gl10}, {"bk16", bk16}};

struct Arguments {
  std::vector<Paper> papers;
  Settings settings;
  std::string json;
};

template <class Number>
Status parse_number(std::string_view flag, std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value > 0) return Done{};
  return Error{std::string(flag) + ": '" + std::string(text) + "' is no positive number"};
}

Status add_paper(std::string_view name, Arguments& arguments) {
  std::vector<std::string_view> known;
  for (const Paper& paper : kPapers) {
    known.push_back(paper.name);
    if (paper.name == name) return arguments.papers.push_back(paper), Done{};
  }
  return unknown_name("paper", name, known);
}

Status set_option(std::string_view flag, const std::string& value, Arguments& arguments) {
  Settings& settings = arguments.settings;
  if (flag == "--scenes") return settings.scenes = value, Done{};
  if (flag == "--json") return arguments.json = value, Done{};
  if (flag == "--size") return parse_number(flag, value, settings.size);
  if (flag == "--repeat") return parse_number(flag, value, settings.repeat);
  if (flag == "--threads") return parse_number(flag, value, settings.threads);
  constexpr std::string_view kFlags[] = {"--scenes", "--size", "--repeat", "--threads", "--json"};
  return unknown_name("option", flag, kFlags);
}

Result<Arguments> parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    Status status = Done{};
    if (!argument.starts_with("-"))
      status = add_paper(argument, arguments);
    else if (++i < argc)
      status = set_option(argument, argv[i], arguments);
    else
      status = Error{std::string(argument) + " needs a value"};
    if (!status) return status.error();
  }
  if (arguments.papers.empty()) arguments.papers.assign(std::begin(kPapers), std::end(kPapers));
  return arguments;
}

bool write_json(const std::string& path, const Json& json) {
  if (path == "-") return static_cast<bool>(std::cout << json.dump(2) << '\n');
  return static_cast<bool>(std::ofstream(path) << json.dump(2) << '\n');
}

int run(int argc, char** argv) {
  for (const std::string_view argument : std::span(argv, static_cast<std::size_t>(argc)))
    if (argument == "--help") return std::cout << kHelp, 0;
  const Result<Arguments> arguments = parse(argc, argv);
  if (!arguments) return std::cerr << "error: " << arguments.message() << '\n', 2;
  const Settings& settings = arguments->settings;
  Json json;
  json["context"] = {{"executable", "paper_tables"}, {"library_version", kVersion}, {"size", settings.size},
                     {"threads", settings.threads},  {"repeat", settings.repeat},   {"scenes", settings.scenes}};
  json["benchmarks"] = Json::array();
  for (const Paper& paper : arguments->papers) {
    const Result<Report> report = paper.make(settings);
    if (!report) return std::cerr << "error: " << paper.name << ": " << report.message() << '\n', 1;
    if (arguments->json != "-") std::cout << report->text << std::flush;
    for (const Json& row : report->rows) json["benchmarks"].push_back(row);
  }
  if (!arguments->json.empty() && !write_json(arguments->json, json))
    return std::cerr << "error: cannot write " << arguments->json << '\n', 1;
  return 0;
}

}  // namespace
}  // namespace accel::paper_tables

int main(int argc, char** argv) { return accel::paper_tables::run(argc, argv); }
