#include "apps/common/stress_state.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/common/output.h"
#include "libaccel/io/input_bytes.h"

namespace accel::apps {

namespace {

using Json = nlohmann::ordered_json;
using validation::StressTally;

constexpr const char* kFormat = "accel-trace stress, 2";

// The names of a tally's numbers in the file.
constexpr std::pair<const char*, std::uint64_t StressTally::*> kNumbers[] = {
    {"rays", &StressTally::rays},     {"leaks", &StressTally::leaks},      {"miss", &StressTally::miss},
    {"far", &StressTally::far},       {"false", &StressTally::false_hit},  {"broken", &StressTally::broken},
    {"judged", &StressTally::judged}, {"unjudged", &StressTally::unjudged}};

Json json_of(const StressState& state) {
  Json entries = Json::array();
  for (const auto& [key, entry] : state.entries) {
    Json one = {{"case", key.first}, {"engine", key.second}, {"rounds", entry.rounds}, {"asked", entry.asked}};
    for (const auto& [name, number] : kNumbers) one[name] = entry.tally.*number;
    if (!entry.error.empty()) one["error"] = entry.error;
    entries.push_back(std::move(one));
  }
  return {{"format", kFormat}, {"seed", state.seed}, {"seconds", state.seconds}, {"entries", std::move(entries)}};
}

// Throws what the JSON library throws where something is missing or of another kind.
StressState state_of(const Json& json) {
  StressState state;
  state.seed = json.at("seed").get<std::uint64_t>(), state.seconds = json.at("seconds").get<double>();
  for (const Json& one : json.at("entries")) {
    StressEntry& entry = state.entries[{one.at("case").get<std::string>(), one.at("engine").get<std::string>()}];
    entry.rounds = one.at("rounds").get<std::uint64_t>(), entry.asked = one.at("asked").get<std::uint64_t>();
    for (const auto& [name, number] : kNumbers) entry.tally.*number = one.at(name).get<std::uint64_t>();
    entry.error = one.value("error", std::string());
  }
  return state;
}

}  // namespace

Outcome<StressState> load_stress_state(const std::string& path, std::uint64_t seed) {
  if (path.empty() || !std::filesystem::exists(path)) return StressState{.seed = seed};
  const Result<InputBytes> input = read_input(path);
  if (!input) return input.error();
  const Json json = Json::parse(input->text(), nullptr, false);
  const auto format = json.find("format");
  if (!json.is_object() || format == json.end() || *format != kFormat)
    return Error{path + " holds no state of accel-trace stress; name another file, or remove it"};
  try {
    StressState state = state_of(json);
    if (state.seed == seed) return state;
    return Error{path + " is of a run with seed " + std::to_string(state.seed) + "; use --seed " + std::to_string(state.seed) +
                 ", or another file"};
  } catch (const nlohmann::json::exception& error) {
    return Error{path + " is damaged: " + error.what()};
  }
}

Finished save_stress_state(const std::string& path, const StressState& state) {
  if (path.empty()) return Done{};
  return write_text(path, json_of(state).dump(1) + "\n");
}

}  // namespace accel::apps
