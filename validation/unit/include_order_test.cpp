// The dependency rules of the tree, read from its #include lines.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Include {
  std::string path;
  bool quoted;
};

struct SourceFile {
  std::string path;   // from the root of the tree
  std::string layer;  // "core", ..., "accel.h" for the umbrella, "scenes", "validation", "apps", "bench"
  std::vector<Include> includes;
  std::vector<std::string> lines;
};

// The layer of a path: its folder in libaccel, or its top-level folder.
std::string layer_of(const std::string& path) {
  const std::size_t slash = path.find('/');
  const std::string top = path.substr(0, slash);
  if (top != "libaccel") return top;
  const std::string rest = path.substr(slash + 1);
  return rest.substr(0, rest.find('/'));
}

SourceFile read_source(const fs::path& root, const fs::path& file) {
  SourceFile source;
  source.path = file.lexically_relative(root).generic_string();
  source.layer = layer_of(source.path);
  const std::regex include(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  std::ifstream in(file);
  std::smatch match;
  for (std::string line; std::getline(in, line); source.lines.push_back(line))
    if (std::regex_search(line, match, include)) source.includes.push_back({match[2], match[1] == "\""});
  return source;
}

const std::vector<SourceFile>& sources() {
  static const std::vector<SourceFile> all = [] {
    const fs::path root = ACCEL_SOURCE_DIR;
    const std::set<std::string> extensions = {".h", ".cuh", ".cpp", ".cu"};
    std::vector<SourceFile> result;
    for (const char* top : {"libaccel", "scenes", "validation", "apps", "bench"})
      for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / top))
        if (extensions.contains(entry.path().extension().string())) result.push_back(read_source(root, entry.path()));
    return result;
  }();
  return all;
}

bool starts_with(const std::string& text, const std::string& prefix) { return text.rfind(prefix, 0) == 0; }

// The layers below each layer. A layer may include itself.
const std::map<std::string, std::set<std::string>>& below() {
  static const std::map<std::string, std::set<std::string>> rules = [] {
    std::map<std::string, std::set<std::string>> r;
    r["core"] = {};
    r["geometry"] = {"core"};
    r["structure"] = {"core", "geometry"};
    r["trace"] = r["build"] = r["io"] = r["rays"] = {"core", "geometry", "structure"};
    r["packet"] = {"core", "geometry", "structure", "trace", "build"};
    r["exec"] = {"core", "geometry", "structure", "trace", "build", "packet"};
    r["registry"] = {"core", "geometry", "structure", "trace", "build", "packet", "exec", "io"};  // files of any structure
    r["accel.h"] = r["registry"];
    for (const char* layer : {"registry", "rays"}) r["accel.h"].insert(layer);
    r["scenes"] = {"core", "geometry"};
    r["validation"] = r["accel.h"];
    for (const char* layer : {"accel.h", "scenes"}) r["validation"].insert(layer);
    r["apps"] = r["bench"] = r["validation"];
    for (const char* layer : {"apps", "bench"}) r[layer].insert("validation");
    return r;
  }();
  return rules;
}

// Kernels are instantiated for every method, so the CUDA executor reads the registry. Nothing else looks upwards.
bool is_exempt(const SourceFile& source, const std::string& include) {
  return starts_with(source.path, "libaccel/exec/cuda/") && starts_with(include, "libaccel/registry/");
}

TEST(IncludeOrder, FindsTheTree) {
  EXPECT_GT(sources().size(), 20u);
  for (const SourceFile& source : sources())
    EXPECT_TRUE(below().contains(source.layer)) << source.path << ": no rule for this folder";
}

TEST(IncludeOrder, LayersLookDownwardsOnly) {
  for (const SourceFile& source : sources())
    for (const Include& include : source.includes) {
      if (!include.quoted || is_exempt(source, include.path)) continue;
      const std::string target = layer_of(include.path);
      EXPECT_TRUE(target == source.layer || below().at(source.layer).contains(target))
          << source.path << " includes " << include.path << ", but " << source.layer << " stands below " << target;
    }
}

TEST(IncludeOrder, QuotedPathsStartAtTheRootAndExist) {
  const fs::path root = ACCEL_SOURCE_DIR;
  for (const SourceFile& source : sources())
    for (const Include& include : source.includes)
      if (include.quoted) {
        EXPECT_TRUE(fs::exists(root / include.path)) << source.path << " includes " << include.path;
      }
}

// The files that include anything whose path starts with one of the prefixes.
std::set<std::string> includers(const std::vector<std::string>& prefixes) {
  std::set<std::string> result;
  for (const SourceFile& source : sources())
    for (const Include& include : source.includes)
      for (const std::string& prefix : prefixes)
        if (!include.quoted && starts_with(include.path, prefix)) result.insert(source.path);
  return result;
}

TEST(IncludeOrder, EmbreeLivesInOneFileOfTheOracle) {
  EXPECT_THAT(includers({"embree"}), testing::ElementsAre("validation/oracle/embree.cpp"));
}

TEST(IncludeOrder, OpenImageIoLivesInOneFileOfTheApps) {
  const std::set<std::string> files = includers({"OpenImageIO"});
  EXPECT_LE(files.size(), 1u) << testing::PrintToString(files);
  for (const std::string& file : files) EXPECT_TRUE(starts_with(file, "apps/")) << file;
}

TEST(IncludeOrder, CudaLivesUnderExecCuda) {
  for (const std::string& file : includers({"cuda", "cub/", "thrust/", "cooperative_groups"}))
    EXPECT_TRUE(starts_with(file, "libaccel/exec/cuda/")) << file;
}

// Highway compiles what ends in -inl.h once for every target of the machine's family.
TEST(IncludeOrder, EveryHeaderIsGuarded) {
  for (const SourceFile& source : sources()) {
    if (!source.path.ends_with(".h") && !source.path.ends_with(".cuh")) continue;
    const std::string guard = source.path.ends_with("-inl.h") ? "defined(HWY_TARGET_TOGGLE)" : "#pragma once";
    EXPECT_THAT(source.lines, testing::Contains(testing::HasSubstr(guard))) << source.path;
  }
}

// Conditional compilation hides code from whoever reads or tests another configuration.
bool may_be_conditional(const std::string& path) {
  static const std::set<std::string> files = {"libaccel/core/hd.h", "libaccel/trace/box_pair.h",
                                              "libaccel/geometry/watertight.h", "validation/oracle/embree.cpp"};
  return files.contains(path) || path.find("_simd") != std::string::npos || starts_with(path, "libaccel/exec/cuda/");
}

TEST(IncludeOrder, ConditionalCompilationIsConfined) {
  const std::regex conditional(R"(^\s*#\s*(if|ifdef|ifndef|elif)\b)");
  for (const SourceFile& source : sources()) {
    if (may_be_conditional(source.path)) continue;
    for (const std::string& line : source.lines)
      EXPECT_FALSE(std::regex_search(line, conditional)) << source.path << ": " << line;
  }
}

}  // namespace
