// What the conformance tests share: they run for every method of the registry, through the public interface. Robust
// methods with the first triangle test promise their hits; other tests promise little, and there one method of each structure
// stands for all.
#pragma once

#include <gtest/gtest.h>

#include <ostream>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "libaccel/registry/any_accel.h"
#include "validation/compare/judge.h"
#include "validation/compare/same_hit.h"

namespace accel {

inline bool operator==(const Hit& a, const Hit& b) { return validation::same_hit(a, b); }
inline std::ostream& operator<<(std::ostream& out, const Hit& hit) {
  return out << "{t " << hit.t << ", u " << hit.u << ", v " << hit.v << ", prim_id " << static_cast<std::int64_t>(hit.prim_id)
             << '}';
}

}  // namespace accel

namespace accel::validation {

struct MethodCase {
  std::string method, test;
};
inline std::ostream& operator<<(std::ostream& out, const MethodCase& c) { return out << c.method << " with " << c.test; }

class MethodTest : public testing::TestWithParam<MethodCase> {
 protected:
  // The method under test, over a mesh.
  static AnyAccel build(const TriangleMesh& mesh) { return build(mesh, GetParam().method); }
  static AnyAccel build_brute_force(const TriangleMesh& mesh) { return build(mesh, "brute/loop"); }

  static AnyAccel build(const TriangleMesh& mesh, const std::string& method) {
    Result<AnyAccel> accel = AnyAccel::build(mesh, method);
    if (!accel) throw std::runtime_error(accel.message());
    return std::move(accel).value();
  }

  // The answers of a method with the triangle test under test.
  static std::vector<Hit> closest(const AnyAccel& accel, const std::vector<Ray>& rays, int threads = 1) {
    std::vector<Hit> hits(rays.size());
    const Status status = accel.closest(rays, hits, {.threads = threads, .test = GetParam().test});
    EXPECT_TRUE(status) << status.message();
    return hits;
  }
  static std::vector<std::uint8_t> occluded(const AnyAccel& accel, const std::vector<Ray>& rays, int threads = 1) {
    std::vector<std::uint8_t> result(rays.size());
    const Status status = accel.occluded(rays, result, {.threads = threads, .test = GetParam().test});
    EXPECT_TRUE(status) << status.message();
    return result;
  }

  static bool is_watertight() { return GetParam().test == triangle_tests().front(); }

  // The answers of two ways to the same hits are the same, bit for bit, but for one ray in a thousand of those that hurt most,
  // and exact arithmetic must excuse the answer: a triangle test rounds, and may see a triangle that the ray passes by a hair
  // outside of the box that holds it exactly.
  //
  // Moeller and Trumbore's test has no bound on its errors, so its hits may lie far outside of their boxes: one ray in a
  // hundred may differ, and slivers, where hits of this test are mostly errors, are not compared.
  static void expect_same(const std::string& what, const Judge& judge, const std::vector<Ray>& rays,
                          const std::vector<Hit>& ours, const std::vector<Hit>& expected) {
    if (!is_watertight() && what == "slivers") return;
    std::size_t different = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (ours[i] == expected[i]) continue;
      ++different;
      if (!is_watertight()) continue;
      const Verdict verdict = judge.judge(rays[i], ours[i], judge.oracle().closest(rays[i]));
      EXPECT_FALSE(is_failure(verdict)) << what << ", ray " << i << ": " << ours[i] << ", expected " << expected[i]
                                        << ", which is " << to_string(verdict);
    }
    EXPECT_LE(different, 1 + rays.size() / (is_watertight() ? 1000 : 100)) << what;
  }
};

// Every robust method with the test that promises its hits.
inline std::vector<MethodCase> promised_cases() {
  std::vector<MethodCase> cases;
  for (const MethodInfo& method : methods())
    if (method.robust) cases.push_back({method.name, triangle_tests().front()});
  return cases;
}

// These, and the first method of each structure with the second test.
inline std::vector<MethodCase> all_cases() {
  std::vector<MethodCase> cases = promised_cases();
  std::set<std::string> structures;
  for (const MethodInfo& method : methods())
    if (structures.insert(method.structure).second) cases.push_back({method.name, triangle_tests()[1]});
  return cases;
}

inline std::string case_name(const testing::TestParamInfo<MethodCase>& info) {
  std::string name = info.param.method + "_" + info.param.test;
  for (char& c : name)
    if (c == '/' || c == '-') c = '_';
  return name;
}

}  // namespace accel::validation

// Runs a suite derived from MethodTest for all cases, or where hits are promised.
#define ACCEL_FOR_EVERY_METHOD(Suite) \
  INSTANTIATE_TEST_SUITE_P(Methods, Suite, testing::ValuesIn(accel::validation::all_cases()), accel::validation::case_name)
#define ACCEL_FOR_EVERY_PROMISE(Suite) \
  INSTANTIATE_TEST_SUITE_P(Methods, Suite, testing::ValuesIn(accel::validation::promised_cases()), accel::validation::case_name)
