#include "validation/stress/laws.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/float_bounds.h"
#include "libaccel/core/vec3d.h"
#include "libaccel/registry/any_accel.h"
#include "validation/compare/judge_hits.h"
#include "validation/compare/same_hit.h"

namespace accel::validation {
namespace {

constexpr std::size_t kMostCases = 8;

Vec3 times_power_of_two(Vec3 v, int k) { return {std::ldexp(v.x, k), std::ldexp(v.y, k), std::ldexp(v.z, k)}; }
Vec3 turned(Vec3 v) { return {v.y, v.z, v.x}; }

template <class Change>
TriangleMesh with_vertices(const TriangleMesh& mesh, const Change& change) {
  TriangleMesh result{Buffer<Vec3>::copy_of(mesh.vertices.span()), mesh.triangles};
  for (Vec3& v : result.vertices) v = change(v);
  return result;
}

// One law on one scene. Each law adds pairs of answers to the result.
class LawCheck {
 public:
  LawCheck(const StressScene& scene, const std::vector<Ray>& rays, const LawSubject& subject)
      : scene_(scene), rays_(rays), subject_(subject) {}

  Result<LawResult> run(Law law) {
    switch (law) {
      case Law::scale:
        scale();
        break;
      case Law::order:
        order();
        break;
      case Law::axes:
        axes();
        break;
      case Law::unions:
        unions();
        break;
      case Law::reversed:
        reversed();
        break;
      case Law::any:
        any();
        break;
      case Law::intervals:
        intervals();
        break;
    }
    if (!error_.message.empty()) return error_;
    return std::move(result_);
  }

 private:
  // The method under test over a mesh. After a failed build nothing more is compared.
  std::optional<AnyAccel> build(const TriangleMesh& mesh) {
    if (!error_.message.empty()) return std::nullopt;
    Result<AnyAccel> accel = AnyAccel::build(mesh, subject_.method);
    if (accel) return *std::move(accel);
    error_ = accel.error();
    return std::nullopt;
  }
  TraceOptions options() const { return {.threads = subject_.threads, .test = subject_.test}; }

  std::vector<Hit> closest(const std::optional<AnyAccel>& accel, const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    if (!accel) return hits;
    if (const Status s = accel->closest(rays, hits, options()); !s) error_ = s.error();
    return hits;
  }
  std::vector<std::uint8_t> occluded(const std::optional<AnyAccel>& accel, const std::vector<Ray>& rays) {
    std::vector<std::uint8_t> answers(rays.size());
    if (!accel) return answers;
    if (const Status s = accel->occluded(rays, answers, options()); !s) error_ = s.error();
    return answers;
  }

  const Judge& judge() {
    if (!judge_) judge_.emplace(scene_.mesh);
    return *judge_;
  }
  bool is_excused(const Ray& ray, const Hit& hit) {
    return !is_failure(judge().judge(ray, hit, judge().oracle().closest(ray)));
  }

  void violated(std::size_t number, const Ray& ray, const Hit& ours, const Hit& expected, const std::string& what) {
    if (result_.broken++ == 0) result_.what = scene_.name + ", ray " + std::to_string(number) + ": " + what;
    if (result_.cases.size() < kMostCases) result_.cases.push_back({number, ray, Verdict::unjudged, ours, expected});
  }

  // Answers that must be the same in every bit.
  void expect_identical(const std::vector<Ray>& rays, const std::vector<Hit>& ours, const std::vector<Hit>& expected,
                        const std::string& what) {
    result_.rays += rays.size();
    for (std::size_t i = 0; i < rays.size(); ++i)
      if (!same_hit(ours[i], expected[i])) ++result_.different, violated(i, rays[i], ours[i], expected[i], what);
  }

  // Answers that must be the same where rounding does not decide. The rays are in the space of the scene.
  void expect_same(const std::vector<Ray>& rays, const std::vector<Hit>& ours, const std::vector<Hit>& expected,
                   const std::string& what) {
    result_.rays += rays.size();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (same_hit(ours[i], expected[i])) continue;
      ++result_.different;
      if (!subject_.is_watertight()) continue;
      if (!is_excused(rays[i], ours[i]) || !is_excused(rays[i], expected[i])) violated(i, rays[i], ours[i], expected[i], what);
    }
  }

  // The determinant of Moeller and Trumbore's test grows with the third power of the scale, so its range is smaller.
  void scale() {
    const std::vector<int> exponents =
        subject_.is_watertight() ? std::vector{-40, -13, -1, 1, 6, 40} : std::vector{-8, -1, 1, 8};
    std::vector<Ray> scalable;
    for (const Ray& ray : rays_)
      if (is_exact(ray.org, exponents.front()) && is_exact(ray.dir, exponents.front())) scalable.push_back(ray);
    scale(scalable, exponents);
  }
  // Whether scaling loses no bit to underflow.
  static bool is_exact(Vec3 v, int k) {
    const Vec3 there_and_back = times_power_of_two(times_power_of_two(v, k), -k);
    return there_and_back.x == v.x && there_and_back.y == v.y && there_and_back.z == v.z;
  }
  void scale(const std::vector<Ray>& rays, const std::vector<int>& exponents) {
    const std::vector<Hit> hits = closest(build(scene_.mesh), rays);
    for (const int k : exponents) {
      const auto accel = build(with_vertices(scene_.mesh, [&](Vec3 v) { return times_power_of_two(v, k); }));
      std::vector<Ray> both = rays, scene_only = rays;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        scene_only[i].org = both[i].org = times_power_of_two(rays[i].org, k);
        both[i].dir = times_power_of_two(rays[i].dir, k);
      }
      std::vector<Hit> expected = hits;
      const std::string times = "times 2^" + std::to_string(k);
      expect_identical(both, closest(accel, both), expected, times);
      for (Hit& hit : expected) hit.t = std::ldexp(hit.t, k);
      expect_identical(scene_only, closest(accel, scene_only), expected, times + ", directions unchanged");
    }
  }

  // Among equals the lowest number wins: a tie is the same answer if it does.
  void order() {
    std::vector<std::uint32_t> original(scene_.mesh.size());  // the number that triangle i had
    std::iota(original.begin(), original.end(), 0u);
    CounterRng rng(1, 0);
    for (auto i = static_cast<std::uint32_t>(original.size()); i > 1; --i)
      std::swap(original[i - 1], original[rng.next_below(i)]);
    TriangleMesh shuffled{scene_.mesh.vertices, Buffer<IndexTriple>(scene_.mesh.size())};
    for (std::size_t i = 0; i < original.size(); ++i) shuffled.triangles[i] = scene_.mesh.triangles[original[i]];

    const std::vector<Hit> before = closest(build(scene_.mesh), rays_);
    std::vector<Hit> after = closest(build(shuffled), rays_);
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      if (!after[i].valid()) continue;
      const std::uint32_t prim_id = original[after[i].prim_id];
      const bool tie = before[i].valid() && prim_id != before[i].prim_id && after[i].t == before[i].t;
      if (tie && before[i].prim_id > prim_id) violated(i, rays_[i], before[i], after[i], "the lowest number did not win");
      if (tie)
        after[i] = before[i];
      else
        after[i].prim_id = prim_id;
    }
    expect_same(rays_, after, before, "in another order");
  }

  void axes() {
    const std::vector<Hit> expected = closest(build(scene_.mesh), rays_);
    TriangleMesh mesh = scene_.mesh;
    std::vector<Ray> rays = rays_;
    for (int turn = 1; turn < 3; ++turn) {
      mesh = with_vertices(mesh, turned);
      for (Ray& ray : rays) ray.org = turned(ray.org), ray.dir = turned(ray.dir);
      std::vector<Hit> hits = closest(build(mesh), rays);
      // Where two components of a direction are equally large, another axis is the first of them: u, v and t's last bit may
      // change, and nothing else.
      for (std::size_t i = 0; i < hits.size(); ++i)
        if (hits[i].prim_id == expected[i].prim_id && is_near(hits[i], expected[i])) hits[i] = expected[i];
      expect_same(rays_, hits, expected, "axes exchanged");
    }
  }
  static bool is_near(const Hit& a, const Hit& b) { return a.t == b.t || std::fabs(a.t - b.t) <= 0x1p-20f * std::fabs(b.t); }

  void unions() {
    const std::size_t half = scene_.mesh.size() / 2;
    const auto part = [&](std::size_t begin, std::size_t end) {
      return TriangleMesh{scene_.mesh.vertices,
                          Buffer<IndexTriple>::copy_of(scene_.mesh.triangles.span().subspan(begin, end - begin))};
    };
    const std::vector<Hit> in_first = closest(build(part(0, half)), rays_),
                           in_second = closest(build(part(half, scene_.mesh.size())), rays_);
    std::vector<Hit> expected = in_first;
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      if (!(in_second[i].t < in_first[i].t)) continue;
      expected[i] = in_second[i];
      expected[i].prim_id += static_cast<std::uint32_t>(half);
    }
    expect_same(rays_, closest(build(scene_.mesh), rays_), expected, "the nearer of two parts");
  }

  // The prim_ids of all hits of each ray, in ascending order.
  std::vector<std::vector<Hit>> all_hits(const std::optional<AnyAccel>& accel, const std::vector<Ray>& rays) {
    const std::size_t most = std::max<std::size_t>(1, scene_.mesh.size());
    std::vector<std::vector<Hit>> lists(rays.size());
    if (!accel) return lists;
    std::vector<Hit> hits(most);
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Status s = accel->k_nearest({&rays[i], 1}, most, hits, {&count, 1}, options());
      if (!s) error_ = s.error();
      lists[i].assign(hits.begin(), hits.begin() + count);
    }
    return lists;
  }
  static std::vector<std::uint32_t> numbers_of(const std::vector<Hit>& hits) {
    std::vector<std::uint32_t> numbers;
    for (const Hit& hit : hits) numbers.push_back(hit.prim_id);
    std::sort(numbers.begin(), numbers.end());
    return numbers;
  }

  // A segment whose two ends and difference are floats, near the one that the ray gives. False where there is none.
  static bool make_segment(const Ray& ray, Ray& forth, Ray& back) {
    const Vec3 end = (Vec3d(ray.org) + Vec3d(ray.dir) * 1.5).to_float();
    forth = {.org = ray.org, .t_min = 0, .dir = (Vec3d(end) - Vec3d(ray.org)).to_float(), .t_max = 1};
    const Vec3d other = Vec3d(forth.org) + Vec3d(forth.dir);
    back = {.org = other.to_float(), .t_min = 0, .dir = forth.dir * -1.0f, .t_max = 1};
    const Vec3d rounded(back.org);
    return is_traceable(forth) && is_traceable(back) && rounded.x == other.x && rounded.y == other.y && rounded.z == other.z;
  }

  // Where the sets differ, each must be one that rounding may give.
  void reversed() {
    std::vector<Ray> forth, back;
    for (const Ray& ray : rays_)
      if (Ray f, b; make_segment(ray, f, b)) forth.push_back(f), back.push_back(b);
    const auto accel = build(scene_.mesh);
    const auto there = all_hits(accel, forth), here = all_hits(accel, back);
    result_.rays += forth.size();
    for (std::size_t i = 0; i < forth.size(); ++i) {
      if (numbers_of(there[i]) == numbers_of(here[i])) continue;
      ++result_.different;
      if (!subject_.is_watertight()) continue;
      const HitsVerdict a = judge_hits(judge(), forth[i], there[i]), b = judge_hits(judge(), back[i], here[i]);
      if (a.failures() + b.failures() > 0 || !are_doubtful({forth[i], back[i]}, there[i], here[i]))
        violated(i, forth[i], there[i].empty() ? Hit{} : there[i][0], here[i].empty() ? Hit{} : here[i][0], "reversed");
    }
  }
  // Whether rounding decides about all triangles that one list has and the other lacks: the segment passes them near an edge,
  // or they are near one of its ends.
  bool are_doubtful(const std::array<Ray, 2>& segment, const std::vector<Hit>& a, const std::vector<Hit>& b) {
    std::vector<std::uint32_t> only;
    const auto first = numbers_of(a), second = numbers_of(b);
    std::set_symmetric_difference(first.begin(), first.end(), second.begin(), second.end(), std::back_inserter(only));
    const auto is_sure = [&](std::uint32_t prim, const Ray& ray) {
      const TriangleBounds bounds = judge().bounds(ray, prim);
      return bounds.possible && !bounds.near_any_edge() && bounds.t_lo > 0 && bounds.t_hi < 1;
    };
    return std::none_of(only.begin(), only.end(),
                        [&](std::uint32_t prim) { return is_sure(prim, segment[0]) && is_sure(prim, segment[1]); });
  }

  void any() {
    const auto accel = build(scene_.mesh);
    const std::vector<Hit> hits = closest(accel, rays_);
    const std::vector<std::uint8_t> answers = occluded(accel, rays_);
    result_.rays += rays_.size();
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      if ((answers[i] != 0) == hits[i].valid()) continue;
      ++result_.different;
      violated(i, rays_[i], answers[i] != 0 ? Hit{.t = 0, .prim_id = kNoHit - 1} : Hit{}, hits[i],
               "any hit is not closest hit");
    }
  }

  // Whether the hit's distance is more than rounding errors of the origin: rays that start on a surface meet it at any t.
  static bool is_away(const Ray& ray, const Hit& hit) {
    const int org = largest_axis(ray.org), dir = largest_axis(ray.dir);
    return hit.t * std::fabs(ray.dir[dir]) > 0x1p-12f * std::fabs(ray.org[org]);
  }

  void intervals() {
    const auto accel = build(scene_.mesh);
    const std::vector<Hit> all = closest(accel, rays_);
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    for (std::size_t i = 0; i < rays_.size(); ++i)
      if (all[i].valid() && is_away(rays_[i], all[i])) rays.push_back(rays_[i]), hits.push_back(all[i]);
    const auto refined = [&](auto&& begin, auto&& end) {
      std::vector<Ray> result = rays;
      for (std::size_t i = 0; i < rays.size(); ++i) result[i].t_min = begin(hits[i].t), result[i].t_max = end(hits[i].t);
      return result;
    };
    const auto zero = [](float) { return 0.0f; };
    const auto same = [](float t) { return t; };
    const auto infinite = [](float) { return std::numeric_limits<float>::infinity(); };
    for (const auto& [part, what] :
         {std::pair{refined(zero, same), "[0, t]"}, {refined(same, infinite), "[t, inf]"}, {refined(same, same), "[t, t]"}})
      expect_same(part, closest(accel, part), hits, what);

    const std::vector<Ray> before = refined(zero, next_down), behind = refined(next_up, infinite);
    const std::vector<std::uint8_t> answers = occluded(accel, before);
    const std::vector<Hit> later = closest(accel, behind);
    result_.rays += 2 * rays.size();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (answers[i] != 0) violated(i, before[i], Hit{.t = 0, .prim_id = kNoHit - 1}, Hit{}, "a hit in front of the first");
      if (!(later[i].t > hits[i].t)) violated(i, behind[i], later[i], Hit{}, "a hit before the interval");
    }
  }

  const StressScene& scene_;
  const std::vector<Ray>& rays_;
  LawSubject subject_;
  std::optional<Judge> judge_;
  LawResult result_;
  Error error_;
};

}  // namespace

LawResult& LawResult::operator+=(const LawResult& other) {
  rays += other.rays, different += other.different, broken += other.broken;
  if (what.empty()) what = other.what;
  return *this;
}

// Features of 2^-40 leave the range of the watertight test when they are scaled by 2^-40 (geometry/watertight.h);
// coordinates at the limit leave the library's. And from rays that start around all of the nested boxes, half of them are too
// far away for what structures of cells promise (trace/cell_ray.h).
bool has_range_for(Law law, const StressScene& scene) {
  if (law == Law::scale) return scene.name != "nested" && scene.name != "broken";
  return law != Law::unions || scene.name != "nested";
}

Result<LawResult> check_law(Law law, const StressScene& scene, const std::vector<Ray>& rays, const LawSubject& subject) {
  return LawCheck(scene, rays, subject).run(law);
}

}  // namespace accel::validation
