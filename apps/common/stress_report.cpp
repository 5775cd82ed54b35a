#include "apps/common/stress_report.h"

#include <nlohmann/json.hpp>

#include "apps/common/rate_text.h"
#include "apps/common/table.h"
#include "apps/common/text.h"
#include "apps/common/versions.h"
#include "validation/oracle/embree.h"

namespace accel::apps {

namespace {

using Align = Table::Align;
using Json = nlohmann::ordered_json;
using validation::Expected;
using validation::StressCase;
using validation::StressTally;

const char* short_expectation(Expected expected) {
  switch (expected) {
    case Expected::clean:
      return "clean";
    case Expected::all_misses:
      return "misses";
    case Expected::build_error:
      return "no build";
    case Expected::first_of_copies:
      return "first copy";
    case Expected::lawful:
      return "lawful";
    case Expected::no_leak:
      return "no leak";
    case Expected::measured:
      return "measured";
  }
  return "";
}

std::string count_text(std::uint64_t n) {
  return n < 10'000'000 ? with_commas(n) : print("%.4g M", static_cast<double>(n) * 1e-6);
}

// The rays with something wrong: those that leak are counted as misses or as far, too.
std::uint64_t wrong_rays(const StressTally& t) { return std::max(t.leaks, t.miss + t.far) + t.false_hit + t.broken; }

// Of the rays that were decided.
validation::Rate wrong_rate(const StressTally& t) { return validation::rate(wrong_rays(t), t.rays - t.unjudged); }

class StressTable {
 public:
  StressTable(const StressReport& report, const StressSettings& settings, const Terminal& terminal)
      : report_(report), settings_(settings), terminal_(terminal) {}

  std::string text() {
    for (const StressCase* one : settings_.cases) add_case(*one);
    return table_.text();
  }

 private:
  const StressEntry* find(const StressCase& one, const std::string& engine) const {
    const auto found = report_.state.entries.find({std::string(one.name), engine});
    return found == report_.state.entries.end() || found->second.rounds == 0 ? nullptr : &found->second;
  }

  void add_case(const StressCase& one) {
    StressEntry good;
    std::vector<std::string> good_methods;
    for (const std::string& method : settings_.methods) {
      const StressEntry* const entry = find(one, method);
      if (entry == nullptr) continue;
      const bool shares_row = !terminal_.verbose() && entry->tally.wrong() == 0 && entry->error.empty();
      if (shares_row)
        good.tally += entry->tally, good_methods.push_back(method);
      else
        add_row(one, method, *entry, true);
    }
    if (good_methods.size() == 1) add_row(one, good_methods.front(), good, true);
    if (good_methods.size() > 1) add_row(one, counted(good_methods.size(), "method"), good, true);
    for (const char* embree : {kEmbreeRobust, kEmbreeFast})
      if (const StressEntry* const entry = find(one, embree)) add_row(one, embree, *entry, false);
  }

  void add_row(const StressCase& one, const std::string& engine, const StressEntry& entry, bool ours) {
    const StressTally& t = entry.tally;
    const auto wrong = [&](std::uint64_t n) {
      return ours && n > 0 && one.expected != Expected::measured ? styled_bad(n) : count_text(n);
    };
    std::string verdict;
    if (ours && is_failure(one, entry))
      verdict = terminal_.styled("FAIL", Style::bad);
    else if (ours)
      verdict = terminal_.styled("ok", Style::good);
    table_.add_row({last_case_ == &one ? "" : std::string(one.name), engine, count_text(t.rays), wrong(t.leaks), wrong(t.miss),
                    wrong(t.far), wrong(t.false_hit), t.broken > 0 ? wrong(t.broken) : "", rate_text(wrong_rate(t)),
                    ours ? short_expectation(one.expected) : "", verdict});
    last_case_ = &one;
  }
  std::string styled_bad(std::uint64_t n) const { return terminal_.styled(count_text(n), Style::bad); }

  const StressReport& report_;
  const StressSettings& settings_;
  const Terminal& terminal_;
  const StressCase* last_case_ = nullptr;
  Table table_{{{"CASE", Align::left},
                {"method", Align::left},
                {"rays"},
                {"leaks"},
                {"miss"},
                {"far"},
                {"false"},
                {"broken"},
                {"wrong/M"},
                {"expected", Align::left},
                {"", Align::left}}};
};

// The entry of a case and a method that is not as expected, or null.
const StressEntry* failed(const StressReport& report, const StressCase& one, const std::string& method) {
  const auto found = report.state.entries.find({std::string(one.name), method});
  return found != report.state.entries.end() && is_failure(one, found->second) ? &found->second : nullptr;
}

// The bundles of failures, or those of the cases that promise nothing.
std::string bundles_text(const StressReport& report, bool of_failures) {
  std::string text;
  for (const StressBundle& bundle : report.bundles)
    if ((failed(report, *bundle.of, bundle.method) != nullptr) == of_failures) text += "  to reproduce: " + bundle.text + "\n";
  return text;
}

// Failures that are none of rays, and where the others can be looked at.
std::string failures_section(const StressReport& report, const StressSettings& settings) {
  std::string text;
  for (const StressCase* one : settings.cases)
    for (const std::string& method : settings.methods) {
      const StressEntry* const entry = failed(report, *one, method);
      if (entry == nullptr) continue;
      text += "  " + std::string(one->name) + " by " + method + ": expected " + std::string(one->expectation);
      text += (entry->error.empty() ? "" : "; " + entry->error) + "\n";
    }
  return text + bundles_text(report, true);
}

}  // namespace

std::string stress_listing() {
  Table table({{"CASE", Align::left}, {"what is traced, and what is expected", Align::left}});
  std::string_view family;
  for (const StressCase& one : validation::stress_cases()) {
    if (!family.empty() && family != one.family()) table.add_gap();
    family = one.family();
    table.add_row({std::string(one.name), std::string(one.what)});
    table.add_row({"", "  -> " + std::string(one.expectation)});
  }
  return table.text();
}

std::string stress_text(const StressReport& report, const StressSettings& settings, const Terminal& terminal) {
  std::string text;
  if (const std::string failures = failures_section(report, settings); !failures.empty())
    text += terminal.styled("NOT AS EXPECTED", Style::bad) + "\n" + failures + "\n";
  text +=
      "Stress, seed " + std::to_string(settings.common.seed) + ", " + seconds_text(report.state.seconds) +
      "; watertight test\nagreement with the witness is taken as right, but for a sample; all else is judged exactly" +
      (settings.embree ? "\nbeside " + validation::EmbreeWitness::version() + ", by the same bounds, on the same rays" : "") +
      "\n";
  text += StressTable(report, settings, terminal).text();
  const std::string measured = bundles_text(report, false);
  return measured.empty() ? text : text + "\nWrong where it is measured, and nothing is promised\n" + measured;
}

std::string stress_json(const StressReport& report, const StressSettings& settings) {
  Json versions_json;
  for (const auto& [name, version] : versions()) versions_json[name] = version;
  Json rows = Json::array();
  for (const StressCase* one : settings.cases)
    for (const auto& [key, entry] : report.state.entries) {
      if (key.first != one->name || entry.rounds == 0) continue;
      const StressTally& t = entry.tally;
      const validation::Rate rate = wrong_rate(t);
      const bool ours = key.second != kEmbreeRobust && key.second != kEmbreeFast;
      Json row = {{"case", key.first},
                  {"engine", key.second},
                  {"rounds", entry.rounds},
                  {"rays", t.rays},
                  {"leaks", t.leaks},
                  {"miss", t.miss},
                  {"far", t.far},
                  {"false", t.false_hit},
                  {"broken", t.broken},
                  {"judged", t.judged},
                  {"unjudged", t.unjudged},
                  {"wrong_per_million", rate.per_million},
                  {"wrong_per_million_bound95", rate.bound95_per_million}};
      if (ours) row["expected"] = one->expectation, row["ok"] = !is_failure(*one, entry);
      if (!entry.error.empty()) row["error"] = entry.error;
      rows.push_back(std::move(row));
    }
  const Json json = {{"context",
                      {{"executable", "accel-trace stress"},
                       {"command_line", settings.common.command_line},
                       {"versions", versions_json},
                       {"seed", settings.common.seed},
                       {"seconds", report.state.seconds}}},
                     {"stress", std::move(rows)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";  // file names need not be UTF-8
}

}  // namespace accel::apps
