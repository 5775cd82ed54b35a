// The tables of the papers, measured and counted anew: ours beside the paper's.
//
// A paper is one function that makes its report, in the file or files that bear its name, and one line in main.cpp.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "libaccel/core/result.h"
#include "libaccel/exec/simt_profile.h"
#include "libaccel/geometry/scene_data.h"
#include "libaccel/rays/ray_sets.h"

namespace accel::paper_tables {

using Json = nlohmann::ordered_json;

struct Settings {
  std::string scenes = "../shared/scenes";  // the folder of the papers' scenes
  std::uint32_t size = 512;                 // pictures have size x size pixels
  int repeat = 5;                           // timed runs, of which the median counts
  int threads = 1;
};

struct Report {
  std::string text;           // 100 columns at most
  Json rows = Json::array();  // in the shape of Google Benchmark's `benchmarks`
};

// A scene of a paper, or the built-in one that stands in for it where its file is missing.
struct PaperScene {
  const char* title;     // as in the paper
  const char* file;      // "NAME.ply.zst" in the folder
  const char* stand_in;  // "builtin:NAME:size"
};
struct LoadedScene {
  SceneData data;
  bool is_stand_in = false;
};
Result<LoadedScene> load(const PaperScene& scene, const Settings& settings);

// With an asterisk where a built-in scene stands in.
std::string title_of(const PaperScene& scene, bool is_stand_in);

// measure(figures, settings) for each scene of a paper's figures; an error names the scene.
template <class SceneResult, class Figures, class Measure>
Result<std::vector<SceneResult>> measure_all(const Figures& scenes, const Measure& measure, const Settings& settings) {
  std::vector<SceneResult> results;
  for (const auto& figures : scenes) {
    Result<SceneResult> result = measure(figures, settings);
    if (!result) return Error{std::string(figures.scene.title) + ": " + result.message()};
    results.push_back(*std::move(result));
  }
  return results;
}

// What the scene's first camera sees, or the default camera: one ray a pixel. And what lights it.
Result<RaySet> primary_rays(const SceneData& scene, std::uint32_t size, PixelOrder order = PixelOrder::rows);
LightDescription light_of(const SceneData& scene);

// A table of text, with columns as wide as their widest cell; the first column is aligned to the left.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> titles) { rows_.push_back(std::move(titles)); }
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  void add_gap() { rows_.emplace_back(); }
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

// What the SIMT model counts, over the phases of the traversal and over all classes of memory.
std::uint64_t issued(const SimtProfile& profile);
SimtProfile::Traffic all_traffic(const SimtProfile& profile);

// Text in lines of at most 100 columns that end with a line break; the first is indented by `first`, the others by `rest`.
std::string paragraph(const std::string& text, std::size_t first = 2, std::size_t rest = 4);

// As printf.
[[gnu::format(printf, 1, 2)]] std::string print(const char* format, ...);

// Text above a table, after an empty line.
std::string heading(const std::string& text);

// Above the notes on where and why figures differ: with what an asterisk means, where a built-in scene stands in.
std::string notes_title(bool has_stand_in);
template <class SceneResult>
std::string notes_title(const std::vector<SceneResult>& results) {
  return notes_title(std::any_of(results.begin(), results.end(), [](const SceneResult& r) { return r.is_stand_in; }));
}

// A row for the JSON: its name is "paper/file/name".
Json new_row(const std::string& paper, const PaperScene& scene, bool is_stand_in, const std::string& name);

// Three digits.
std::string number(double value);
std::string percent(double share);

double median(std::vector<double> values);  // 0 if there are none

double mrays_of(std::size_t rays, double ms);  // millions of rays a second

// Whether answers are the same, bit for bit.
template <class Answer>
bool same_bits(const std::vector<Answer>& a, const std::vector<Answer>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Answer)) == 0);
}

// Does the work, which returns a Status, and notes how long it took.
template <class Work>
Status time_ms(const Work& work, std::vector<double>& times) {
  const auto start = std::chrono::steady_clock::now();
  if (const Status done = work(); !done) return done;
  times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  return Done{};
}

// Foley and Sugerman 2005: Tables 1, 2 and 3.
Result<Report> fs05(const Settings& settings);

// Binder and Keller 2016: Tables 1 and 2, and the histogram of Figure 3.
Result<Report> bk16(const Settings& settings);

// Garanzha and Loop 2010: Table 1, Figures 12 to 15, and what the text of section 5 compares.
Result<Report> gl10(const Settings& settings);

}  // namespace accel::paper_tables
