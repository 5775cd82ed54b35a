// Triangles and rays whose floats are any bits, through every method of the registry.
//
// An input is: a byte that says whether floats are tamed, the numbers of vertices and triangles, the vertices, three bytes a
// triangle, and rays of a byte and eight floats to the end. A ray whose byte is odd is aimed at the vertex that the rest of the
// byte names: its direction is the difference, rounded.
//
// Wild floats are taken as they are. Then no query may crash or fail to end, a hit must lie in its ray's interval, and what is
// no ray must miss.
//
// Tame floats have exponents from 2^-6 to 2^6, or are zero, where single precision keeps distinct vertices apart from any
// origin well enough for the promises of the watertight test. Then the judge must not call any closest hit or any occlusion
// with this test a miss, far or false: neither of brute force nor of any other method. Where methods differ, the judge has so
// excused both, as validation/conformance/method_test.h wants it.
#include <bit>
#include <map>
#include <vector>

#include "libaccel/registry/any_accel.h"
#include "validation/compare/judge.h"
#include "validation/fuzz/fuzz_input.h"

namespace {

using namespace accel;

constexpr std::size_t kMostRays = 16;

// Keeps sign and digits, and folds the exponent into the range; what is in it stays.
float tamed(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t exponent = bits >> 23 & 0xff;
  if (exponent == 0) return std::bit_cast<float>(bits & 0x80000000u);
  const std::uint32_t folded = 127 - 6 + (exponent + 13 * 10 - (127 - 6)) % 13;
  return std::bit_cast<float>((bits & 0x807fffffu) | folded << 23);
}

struct Case {
  bool tame;
  TriangleMesh mesh;
  std::vector<Ray> rays;
};

class CaseReader {
 public:
  explicit CaseReader(fuzz::Input input) : numbers_(input) {}

  Case read() {
    Case result{(numbers_.next<std::uint8_t>() & 1) != 0, {}, {}};
    tame_ = result.tame;
    result.mesh.vertices = Buffer<Vec3>(3 + numbers_.next<std::uint8_t>() % 14);
    result.mesh.triangles = Buffer<IndexTriple>(1 + numbers_.next<std::uint8_t>() % 24);
    for (Vec3& vertex : result.mesh.vertices) vertex = vec3();
    const auto vertices = static_cast<std::uint32_t>(result.mesh.vertices.size());
    const auto index = [&] { return numbers_.next<std::uint8_t>() % vertices; };
    for (IndexTriple& triangle : result.mesh.triangles) triangle.v0 = index(), triangle.v1 = index(), triangle.v2 = index();
    while (!numbers_.empty() && result.rays.size() < kMostRays) result.rays.push_back(ray(result.mesh));
    return result;
  }

 private:
  float number() {
    const auto value = numbers_.next<float>();
    return tame_ ? tamed(value) : value;
  }
  Vec3 vec3() {
    const float x = number(), y = number(), z = number();
    return {x, y, z};
  }
  Ray ray(const TriangleMesh& mesh) {
    const auto aim = numbers_.next<std::uint8_t>();
    Ray result;
    result.org = vec3(), result.t_min = number(), result.dir = vec3(), result.t_max = number();
    if ((aim & 1) != 0) result.dir = mesh.vertices[(aim >> 1) % mesh.vertices.size()] - result.org;
    return result;
  }

  fuzz::NumberReader numbers_;
  bool tame_ = false;
};

struct Answers {
  std::vector<Hit> hits;
  std::vector<std::uint8_t> occluded;
};

Answers trace(const AnyAccel& accel, std::span<const Ray> rays, const std::string& test) {
  Answers answers{std::vector<Hit>(rays.size()), std::vector<std::uint8_t>(rays.size())};
  const TraceOptions options{.threads = 1, .test = test};
  fuzz::require(accel.closest(rays, answers.hits, options).ok(), "closest() fails");
  fuzz::require(accel.occluded(rays, answers.occluded, options).ok(), "occluded() fails");
  return answers;
}

void check_any_input(const Case& input, const Answers& answers, const std::string& who) {
  for (std::size_t i = 0; i < input.rays.size(); ++i) {
    const Ray& ray = input.rays[i];
    const Hit& hit = answers.hits[i];
    const std::string where = who + ", ray " + std::to_string(i) + ": ";
    if (!is_traceable(ray)) fuzz::require(!hit.valid() && answers.occluded[i] == 0, where + "what is no ray hits");
    if (!hit.valid()) continue;
    fuzz::require(hit.prim_id < input.mesh.size(), where + "a triangle that is none");
    fuzz::require(hit.t >= 0 && hit.t >= ray.t_min && hit.t <= ray.t_max, where + "a hit outside of the ray's interval");
  }
}

// What exact arithmetic says of an input's rays; answers that came before need no judging.
class Referee {
 public:
  explicit Referee(const Case& input) : input_(input), judge_(input.mesh) {
    for (const Ray& ray : input.rays) {
      const bool known = is_traceable(ray);
      closest_.push_back(known ? judge_.oracle().closest(ray) : ExactHit{});
      any_.push_back(known && judge_.oracle().any(ray));
    }
  }

  void check(const Answers& answers, const std::string& who) const {
    for (std::size_t i = 0; i < input_.rays.size(); ++i) {
      const Ray& ray = input_.rays[i];
      if (!is_traceable(ray)) continue;
      const validation::Verdict hit = judge_.judge(ray, answers.hits[i], closest_[i]);
      const validation::Verdict any = judge_.judge_any(ray, answers.occluded[i] != 0, any_[i]);
      const std::string where = who + ", ray " + std::to_string(i) + ": ";
      fuzz::require(!is_failure(hit), where + "the closest hit is a " + std::string(to_string(hit)));
      fuzz::require(!is_failure(any), where + "the occlusion is a " + std::string(to_string(any)));
    }
  }

 private:
  using ExactHit = validation::ExactHit;
  const Case& input_;
  validation::Judge judge_;
  std::vector<ExactHit> closest_;
  std::vector<bool> any_;
};

// One build a builder; its other methods share the structure.
class Accels {
 public:
  explicit Accels(const TriangleMesh& mesh) : mesh_(mesh) {}

  AnyAccel with(const MethodInfo& method) {
    const auto built = built_.find(method.builder);
    Result<AnyAccel> accel =
        built != built_.end() ? built->second.with_method(method.name) : AnyAccel::build(mesh_, method.name, {.threads = 1});
    fuzz::require(accel.ok(), method.name + " cannot be built");
    built_.emplace(method.builder, *accel);
    return *std::move(accel);
  }

 private:
  const TriangleMesh& mesh_;
  std::map<std::string, AnyAccel> built_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Case input = CaseReader({data, size}).read();
  const Referee referee(input);
  Accels accels(input.mesh);
  for (const MethodInfo& method : methods()) {
    const AnyAccel accel = accels.with(method);
    for (const std::string& test : triangle_tests()) {
      if (!accel.accepts(test)) continue;
      const std::string who = method.name + " with " + test;
      const Answers answers = trace(accel, input.rays, test);
      check_any_input(input, answers, who);
      if (input.tame && method.robust && test == triangle_tests().front()) referee.check(answers, who);
    }
  }
  return 0;
}
