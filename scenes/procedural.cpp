#include "scenes/procedural.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "libaccel/core/suggest.h"
#include "scenes/generators.h"

namespace accel {
namespace {

struct Generator {
  BuiltinScene scene;
  SceneData (*make)(std::uint64_t size, std::uint64_t seed);
};

constexpr std::array<Generator, 10> kGenerators{{
    {{"stadium", "small, finely tessellated sculptures in a big coarse arena", 500'000}, make_stadium},
    {{"cornell", "the box with a lamp and two blocks, tessellated to size", 32}, make_cornell},
    {{"soup", "random triangles of widely varying sizes", 100'000}, make_soup},
    {{"slivers", "long thin triangles, up to a million times longer than high", 100'000}, make_slivers},
    {{"terrain", "a mountain range as a height field", 500'000}, make_terrain},
    {{"hairball", "thin curly strands around a sphere", 500'000}, make_hairball},
    {{"colonnade", "a vaulted hall of fluted columns, arches and steps", 250'000}, make_colonnade},
    {{"spheres", "a grid of closed spheres with shared vertices", 200'000}, make_spheres},
    {{"forest", "hundreds of instances of three plants on hilly ground", 1'000'000}, make_forest},
    {{"deep", "clusters that shrink along a line: trees deeper than 64 levels", 20'000}, make_deep},
}};

constexpr auto kScenes = [] {
  std::array<BuiltinScene, kGenerators.size()> scenes;
  for (std::size_t i = 0; i < scenes.size(); ++i) scenes[i] = kGenerators[i].scene;
  return scenes;
}();

// "1.5M" is 1500000.
Result<std::uint64_t> parse_size(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view suffix = text.substr(static_cast<std::size_t>(end - text.data()));
  const double scale = suffix.empty() ? 1 : suffix == "k" || suffix == "K" ? 1e3 : suffix == "m" || suffix == "M" ? 1e6 : 0;
  if (error != std::errc() || scale == 0)
    return Error{"bad scene size '" + std::string(text) + "'; give a number of triangles such as 5000, 100k or 2M"};
  const double size = value * scale;
  if (!(size >= 1 && size <= static_cast<double>(kMaxBuiltinSize)))
    return Error{"scene size '" + std::string(text) + "' is out of range; give 1 to " + std::to_string(kMaxBuiltinSize)};
  return static_cast<std::uint64_t>(std::llround(size));
}

struct Wanted {
  const Generator* generator;
  std::uint64_t size;
};

Result<Wanted> parse_spec(std::string_view spec) {
  constexpr std::string_view kPrefix = "builtin:";
  if (spec.starts_with(kPrefix)) spec.remove_prefix(kPrefix.size());
  const std::size_t colon = spec.find(':');
  const std::string_view name = spec.substr(0, colon);

  const auto generator = std::ranges::find(kGenerators, name, [](const Generator& g) { return g.scene.name; });
  if (generator == kGenerators.end()) {
    std::array<std::string_view, kGenerators.size()> names;
    std::ranges::transform(kScenes, names.begin(), &BuiltinScene::name);
    return unknown_name("builtin scene", name, names);
  }
  if (colon == std::string_view::npos) return Wanted{&*generator, generator->scene.default_size};
  const auto size = parse_size(spec.substr(colon + 1));
  if (!size.ok()) return size.error();
  return Wanted{&*generator, *size};
}

}  // namespace

std::uint32_t steps_for(double budget, double per_square) {
  return static_cast<std::uint32_t>(std::max(1.0, std::round(std::sqrt(budget / per_square))));
}

std::span<const BuiltinScene> builtin_scenes() { return kScenes; }

Status check_builtin(std::string_view spec) {
  const auto wanted = parse_spec(spec);
  return wanted ? Status(Done{}) : Status(wanted.error());
}

Result<SceneData> make_builtin(std::string_view spec, std::uint64_t seed) {
  const auto wanted = parse_spec(spec);
  if (!wanted) return wanted.error();
  return wanted->generator->make(wanted->size, seed);
}

}  // namespace accel
