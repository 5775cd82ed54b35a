#include "validation/compare/repro.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <set>

#include "libaccel/io/atomic_file.h"
#include "libaccel/io/npy.h"
#include "validation/compare/error_bounds.h"
#include "validation/compare/shell_quoted.h"

namespace accel::validation {
namespace {

// As printf, at the end of a string.
__attribute__((format(printf, 2, 3))) void append(std::string& text, const char* format, ...) {
  char line[512];
  va_list arguments;
  va_start(arguments, format);
  const int length = std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  text.append(line, static_cast<std::size_t>(std::clamp(length, 0, static_cast<int>(sizeof line) - 1)));
}

void append_number(std::string& text, const char* name, double x) { append(text, "  %s %a (%.9g)", name, x, x); }

void append_point(std::string& text, const char* name, Vec3 p) {
  append(text, "  %-8s %a %a %a  (%.9g %.9g %.9g)\n", name, p.x, p.y, p.z, p.x, p.y, p.z);
}

void append_answer(std::string& text, const char* who, const Hit& hit, Query query) {
  append(text, "  %-8s", who);
  if (query == Query::any) {
    text += hit.valid() ? " occluded\n" : " free\n";
  } else if (hit.valid()) {
    append(text, " prim %u", hit.prim_id);
    append_number(text, "t", hit.t);
    append_number(text, "u", hit.u);
    append_number(text, "v", hit.v);
    text += '\n';
  } else {
    text += " miss\n";
  }
}

void append_exact(std::string& text, const ExactHit& exact) {
  text += "  exact   ";
  if (!exact.valid()) {
    text += " miss\n";
    return;
  }
  append(text, " t* %a (%.17g), hit at exactly this t:", exact.t, exact.t);
  for (const std::uint32_t prim : exact.prims) append(text, " %u", prim);
  text += '\n';
}

void append_triangle(std::string& text, const Ray& ray, const Judge& judge, std::uint32_t prim) {
  const Triangle triangle = judge.oracle().triangles().triangle(prim);
  append(text, "  triangle %u\n", prim);
  append_point(text, "  v0", triangle.v0), append_point(text, "  v1", triangle.v1), append_point(text, "  v2", triangle.v2);
  if (!is_traceable(ray)) return;
  if (!judge.oracle().is_known(prim)) return;
  const TriangleBounds bounds = judge.bounds(ray, prim);
  if (!bounds.possible) {
    text += "    rounding cannot make this a hit\n";
    return;
  }
  append(text, "    may be hit with t in [%.9g, %.9g]; near edge v1-v2 %s, v2-v0 %s, v0-v1 %s\n", bounds.t_lo, bounds.t_hi,
         bounds.edge_near[0] ? "yes" : "no", bounds.edge_near[1] ? "yes" : "no", bounds.edge_near[2] ? "yes" : "no");
}

// The triangles that a case is about: answered, hit exactly, or possible no farther than these.
std::set<std::uint32_t> involved(const Judge& judge, const ReproCase& one, const ExactHit& exact) {
  constexpr std::size_t kEnough = 64;
  std::set<std::uint32_t> prims(exact.prims.begin(), exact.prims.end());
  for (const Hit& hit : {one.ours, one.witness.value_or(Hit{})}) {
    if (hit.prim_id < judge.oracle().triangles().size()) prims.insert(hit.prim_id);
  }
  if (!is_traceable(one.ray)) return prims;
  const double t_end = std::max(exact.valid() ? exact.t : 0.0, one.ours.valid() ? double{one.ours.t} : 0.0);
  for (const std::uint32_t prim : judge.oracle().near(one.ray, kNearPadding, t_end)) {
    if (prims.size() >= kEnough) break;
    if (judge.bounds(one.ray, prim).possible) prims.insert(prim);
  }
  return prims;
}

// Traces the rays of the bundle as the failures were found, and judges them.
std::string again(const std::filesystem::path& rays, const ReproContext& context) {
  std::string text = "accel-trace " + shell_quoted(context.scene);
  for (const std::string& option : context.options) text += " " + shell_quoted(option);
  if (context.query == Query::any) text += " --query any";
  return text + " --method " + context.method + " --check exact --rays " + shell_quoted(rays.string());
}

std::string heading(const std::filesystem::path& rays, std::size_t cases, const ReproContext& context) {
  std::string text = "libaccel: answers that exact arithmetic refutes\n\n";
  text += "found by  " + context.command_line + "\n";
  text += "again     " + again(rays, context) + "\n";
  text += "query     " + std::string(context.query == Query::any ? "any hit" : "closest hit") + "\n";
  append(text, "cases     %zu\n", cases);
  return text;
}

class ObjText {
 public:
  void add(const Triangle& triangle, std::uint32_t prim) {
    append(text_, "# triangle %u\n", prim);
    for (const Vec3 p : {triangle.v0, triangle.v1, triangle.v2}) append(text_, "v %.9g %.9g %.9g\n", p.x, p.y, p.z);
    text_ += "f -3 -2 -1\n";
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::filesystem::path with_suffix(std::filesystem::path stem, const char* suffix) { return stem += suffix; }

template <class Answer>
std::vector<ReproCase> collect(const CheckResult& result, std::span<const Ray> rays, bool has_witness, const Answer& answer) {
  std::vector<ReproCase> cases;
  for (const Failure& failure : result.first_failures) {
    ReproCase one{failure.ray, rays[failure.ray], failure.verdict, answer(failure.ray, false), std::nullopt};
    if (has_witness) one.witness = answer(failure.ray, true);
    cases.push_back(one);
  }
  return cases;
}

}  // namespace

std::vector<ReproCase> repro_cases(const CheckResult& result, std::span<const Ray> rays, std::span<const Hit> ours,
                                   std::span<const Hit> witness) {
  return collect(result, rays, !witness.empty(), [&](std::size_t i, bool other) { return other ? witness[i] : ours[i]; });
}

std::vector<ReproCase> repro_cases(const CheckResult& result, std::span<const Ray> rays, std::span<const std::uint8_t> ours,
                                   std::span<const std::uint8_t> witness) {
  return collect(result, rays, !witness.empty(), [&](std::size_t i, bool other) {
    Hit hit;
    if ((other ? witness[i] : ours[i]) != 0) hit.t = 0, hit.prim_id = kNoHit - 1;  // some triangle: which one is not known
    return hit;
  });
}

Result<std::filesystem::path> write_repro(const std::filesystem::path& stem, const Judge& judge,
                                          std::span<const ReproCase> cases, const ReproContext& context) {
  const std::filesystem::path text_path = with_suffix(stem, ".txt"), rays_path = with_suffix(stem, "-rays.npy");
  std::string text = heading(rays_path, cases.size(), context);
  ObjText obj;
  std::set<std::uint32_t> in_obj;
  std::vector<Ray> rays;
  for (const ReproCase& one : cases) {
    const ExactHit exact = judge.oracle().closest(one.ray);
    append(text, "\nray %zu: %s\n", one.ray_number, std::string(to_string(one.verdict)).c_str());
    append_point(text, "org", one.ray.org), append_point(text, "dir", one.ray.dir);
    append(text, "  interval %a %a  (%.9g %.9g)\n", one.ray.t_min, one.ray.t_max, one.ray.t_min, one.ray.t_max);
    append_answer(text, "ours", one.ours, context.query);
    if (one.witness) append_answer(text, "witness", *one.witness, context.query);
    append_exact(text, exact);
    for (const std::uint32_t prim : involved(judge, one, exact)) {
      append_triangle(text, one.ray, judge, prim);
      if (in_obj.insert(prim).second) obj.add(judge.oracle().triangles().triangle(prim), prim);
    }
    rays.push_back(one.ray);
  }

  if (Status status = write_rays_npy(rays_path, rays); !status) return status.error();
  if (Status status = write_file(with_suffix(stem, ".obj"), obj.text()); !status) return status.error();
  if (Status status = write_file(text_path, text); !status) return status.error();
  return text_path;
}

}  // namespace accel::validation
