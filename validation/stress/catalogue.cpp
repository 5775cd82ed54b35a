#include "validation/stress/catalogue.h"

#include "libaccel/core/suggest.h"

namespace accel::validation {
namespace {

constexpr std::string_view kClean = "no miss, no farther, no false hit; any-hit iff closest hit";
constexpr std::string_view kMisses = "all misses";
constexpr std::string_view kNoLeak = "no leak, no miss, no farther and no false hit";
constexpr std::string_view kFirst = "the bits of brute force over one copy: lowest number wins";
constexpr std::string_view kBudget = "clean; references within max_duplication, max_references";
constexpr std::string_view kSinglePrecisionEnds = "none: vertices collapse; triangles without area are dropped";
constexpr std::string_view kSame = "the same hits, but where exact arithmetic excuses both";

StressCase rays(std::string_view name, std::string_view what, RayKind kind, Expected expected = Expected::clean) {
  const bool clean = expected == Expected::clean;
  return {name, what, clean ? kClean : kMisses, expected, usual_scenes, kind};
}
StressCase geometry(std::string_view name, std::string_view what, SceneMaker scenes, std::uint64_t most_large_rays = 0) {
  return {.name = name,
          .what = what,
          .expectation = kClean,
          .expected = Expected::clean,
          .scenes = scenes,
          .most_large_rays = most_large_rays};
}
StressCase but(StressCase one, Expected expected, std::string_view expectation) {
  one.expected = expected, one.expectation = expectation;
  return one;
}
StressCase law(std::string_view name, std::string_view what, Law law, std::string_view expectation = kSame) {
  return {.name = name,
          .what = what,
          .expectation = expectation,
          .expected = Expected::lawful,
          .scenes = [](SceneSize, std::uint64_t seed) { return stress_scenes(seed); },
          .law = law};
}
StressCase leaks(std::string_view name, std::string_view what, double offset, Expected expected = Expected::no_leak,
                 std::string_view expectation = kNoLeak) {
  return {.name = name, .what = what, .expectation = expectation, .expected = expected, .offset = offset};
}

std::vector<StressCase> make_cases() {
  using enum RayKind;
  return {
      rays("rays/vertices", "through shared vertices, exactly where floats permit it", at_vertices),
      rays("rays/vertices-ulp", "one float beside shared vertices", beside_vertices),
      rays("rays/edges", "through shared edges", at_edges),
      rays("rays/edges-ulp", "one float beside shared edges", beside_edges),
      rays("rays/split-planes", "in planes where trees split, with zeros of both signs", in_split_planes),
      rays("rays/box-faces", "in faces and along edges of boxes", along_boxes),
      rays("rays/axis-parallel", "along axes, with zeros of both signs", axis_parallel),
      rays("rays/from-surfaces", "from points on surfaces and edges", from_surfaces),
      rays("rays/from-vertices", "from vertices", from_vertices),
      rays("rays/from-planes", "from planes of vertices", from_planes),
      rays("rays/t-min-at-hit", "t_min at the hit, or one float beside it", hit_at_t_min),
      rays("rays/t-max-at-hit", "t_max at the hit, or one float beside it", hit_at_t_max),
      rays("rays/intervals", "t_min from -inf, t_max up to inf", all_intervals),
      rays("rays/empty-intervals", "t_max below t_min, by one float or more; t_max below 0", empty_intervals,
           Expected::all_misses),
      rays("rays/lengths", "directions of 2^-100 (1e-30) to 2^60 (1e18)", any_length),
      rays("rays/denormals", "directions with denormal components", denormal_parts),
      rays("rays/in-plane", "in the planes of triangles", in_triangles_planes),
      rays("rays/far-away", "from 100 and 1000 times the scene's size away", far_away),
      but(rays("rays/farther-away", "from 10,000 and a million times the scene's size away", farther_away), Expected::measured,
          "none: triangle tests err by more than kd-trees and grids pad"),
      rays("rays/no-rays", "NaN, infinite, out of range, zero directions", not_rays, Expected::all_misses),

      but(geometry("geometry/empty", "no triangles", empty_scenes), Expected::all_misses, kMisses),
      geometry("geometry/assorted", "soups, dust, terrains, bricks, nested boxes, ...", assorted_scenes),
      geometry("geometry/lattices", "everything in shared planes, at three scales", lattices),
      geometry("geometry/scales", "scenes times 2^-40 to 2^40", scaled_scenes),
      geometry("geometry/translations", "closed meshes at 0, 1, 1e2 and 1e4", translated_scenes),
      but(geometry("geometry/translation-1e6", "closed meshes at 1e6", far_translated_scenes), Expected::measured,
          kSinglePrecisionEnds),
      geometry("geometry/slivers", "three vertices nearly on a line: aspect 1e7", sliver_scenes),
      geometry("geometry/needles", "two vertices 1e-7 apart: aspect 1e7", needle_scenes),
      but(geometry("geometry/zero-area", "points and segments, nothing else", zero_area_scenes), Expected::all_misses, kMisses),
      geometry("geometry/some-zero-area", "triangles without area among others", partly_zero_area_scenes),
      but(geometry("geometry/one-repeated", "one triangle, 300 or a million times", one_many_times, 200),
          Expected::first_of_copies, kFirst),
      but(geometry("geometry/repeated", "a hundred triangles, 4 or 1000 times", few_many_times, 2000),
          Expected::first_of_copies, kFirst),
      geometry("geometry/stacks", "coplanar, and one float apart", stacks_of_planes, 500),
      geometry("geometry/t-junctions", "vertices within edges of neighbours", t_junctions),
      geometry("geometry/flat", "flat scenes, in each axis", flat_scenes),
      geometry("geometry/thin-boxes", "boxes without extent in an axis, or of one float", thin_boxes, 20'000),
      geometry("geometry/one-centroid", "the boxes of 300 or a million triangles around one point", one_centroid, 100),
      but(geometry("geometry/diagonal-slivers", "which spatial splits cut again and again", diagonal_slivers, 1000),
          Expected::clean, kBudget),
      geometry("geometry/deep", "trees deeper than 32, and than 64", deep_trees),
      geometry("geometry/world-in-dust", "a triangle as large as the world among dust", world_among_dust),
      but(geometry("geometry/broken-coordinates", "NaN, infinite, beyond the range", broken_coordinates), Expected::clean,
          "dropped and counted; clean without them"),
      but(geometry("geometry/broken-indices", "an index beyond the vertices", broken_indices), Expected::build_error,
          "the build fails and says why"),

      law("laws/scale", "scene and rays times 2^-40 to 2^40", Law::scale, "bit-identical hits"),
      law("laws/order", "triangles in another order", Law::order, "the same hits, ties to the lowest number"),
      law("laws/axes", "axes exchanged", Law::axes),
      law("laws/union", "two meshes together", Law::unions, "the nearer of the parts' hits"),
      law("laws/reversed", "segments from their other end", Law::reversed, "the same set of triangles"),
      law("laws/any", "any-hit queries", Law::any, "yes iff there is a closest hit"),
      law("laws/intervals", "[0, t], [t, inf], [t, t] of a hit, and one float beside", Law::intervals, "the same hit; none"),

      leaks("leaks/0", "closed meshes of three scales, at the origin", 0),
      leaks("leaks/1", "moved by their size", 1),
      leaks("leaks/1e2", "moved by 100 times their size", 1e2),
      leaks("leaks/1e4", "moved by 10,000 times their size", 1e4),
      leaks("leaks/1e6", "moved by 1,000,000 times their size", 1e6, Expected::measured, kSinglePrecisionEnds),
  };
}

}  // namespace

std::span<const StressCase> stress_cases() {
  static const std::vector<StressCase> cases = make_cases();
  return cases;
}

Result<std::vector<const StressCase*>> find_cases(std::string_view name) {
  std::vector<const StressCase*> found;
  std::vector<std::string_view> known{"rays", "geometry", "laws", "leaks"};
  for (const StressCase& one : stress_cases()) {
    if (one.name == name || one.family() == name) found.push_back(&one);
    known.push_back(one.name);
  }
  if (found.empty()) return unknown_name("case", name, known);
  return found;
}

}  // namespace accel::validation
