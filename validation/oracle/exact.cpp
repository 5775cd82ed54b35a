#include "validation/oracle/exact.h"

#include <algorithm>
#include <cmath>

#include "validation/oracle/exact_predicates.h"

namespace accel::validation {
namespace {

bool in_range(const Triangle& t) { return accel::in_range(t.v0) && accel::in_range(t.v1) && accel::in_range(t.v2); }

// The ends of the ray's interval.
float interval_begin(const Ray& ray) { return ray.t_min > 0 ? ray.t_min : 0.0f; }
float interval_end(const Ray& ray) { return std::min(ray.t_max, std::numeric_limits<float>::max()); }

// A crossing of the ray's line and a triangle, whose t is known as well as was needed so far.
class Crossing {
 public:
  // Nothing if they do not cross inside the ray's interval.
  static std::optional<Crossing> find(const Ray& ray, const Triangle& triangle) {
    const FilteredCrossing filtered = filter_crossing(ray, triangle);
    if (filtered.meets == Decision::no) return std::nullopt;
    Crossing crossing(triangle, filtered.t_lo, filtered.t_hi);
    if (filtered.meets == Decision::unknown) {
      const ExactCrossing exact = exact_crossing(ray, triangle);
      if (!exact.meets()) return std::nullopt;
      crossing.set_exact(exact.t());
    }
    if (!crossing.is_inside(ray)) return std::nullopt;
    return crossing;
  }

  double t_hi() const { return t_hi_; }
  double exact_t(const Ray& ray) { return to_double(exact(ray)); }

  // The sign of this t minus the other's.
  int compare_with(Crossing& other, const Ray& ray) {
    if (t_hi_ < other.t_lo_) return -1;
    if (t_lo_ > other.t_hi_) return 1;
    return compare(exact(ray), other.exact(ray));
  }

 private:
  Crossing(const Triangle& triangle, double t_lo, double t_hi) : triangle_(triangle), t_lo_(t_lo), t_hi_(t_hi) {}

  bool is_inside(const Ray& ray) {
    const float begin = interval_begin(ray), end = interval_end(ray);
    if (t_hi_ < begin || t_lo_ > end) return false;
    if (t_lo_ >= begin && t_hi_ <= end) return true;
    return compare(exact(ray), begin) >= 0 && compare(exact(ray), end) <= 0;
  }

  const ExactRatio& exact(const Ray& ray) {
    if (!exact_) set_exact(exact_crossing(ray, triangle_).t());
    return *exact_;
  }

  void set_exact(ExactRatio t) {
    exact_ = std::move(t);
    const double rounded = to_double(*exact_), error = 0x1p-51 * std::abs(rounded) + std::numeric_limits<double>::min();
    t_lo_ = rounded - error, t_hi_ = rounded + error;
  }

  Triangle triangle_;
  double t_lo_, t_hi_;
  std::optional<ExactRatio> exact_;
};

}  // namespace

bool ExactHit::contains(std::uint32_t prim_id) const { return std::binary_search(prims.begin(), prims.end(), prim_id); }

ExactOracle::ExactOracle(const TriangleMesh& mesh, Search search)
    : mesh_(mesh), search_(search), tree_(search == Search::tree ? mesh : TriangleMesh{}) {}

template <class Visit>
void ExactOracle::visit(const Ray& ray, double padding, double& t_end, Visit&& visit) const {
  if (!is_traceable(ray)) return;
  if (search_ == Search::tree) {
    // Boxes before the interval are of interest when they are inflated, since rounding may move a hit into it.
    tree_.visit(ray, padding, interval_begin(ray), t_end, visit);
    return;
  }
  for (std::uint32_t i = 0; i < mesh_.size(); ++i) {
    if (in_range(mesh_.triangle(i)) && !visit(i)) return;
  }
}

ExactHit ExactOracle::closest(const Ray& ray) const {
  ExactHit hit;
  std::optional<Crossing> best;
  double t_end = interval_end(ray);
  visit(ray, 0.0, t_end, [&](std::uint32_t prim_id) {
    std::optional<Crossing> crossing = Crossing::find(ray, mesh_.triangle(prim_id));
    if (!crossing) return true;
    const int order = best ? crossing->compare_with(*best, ray) : -1;
    if (order > 0) return true;
    if (order < 0) best = std::move(crossing), hit.prims.clear();
    hit.prims.push_back(prim_id);
    t_end = std::min(t_end, best->t_hi());
    return true;
  });
  if (best) hit.t = best->exact_t(ray);
  std::sort(hit.prims.begin(), hit.prims.end());
  return hit;
}

bool ExactOracle::any(const Ray& ray) const {
  bool found = false;
  double t_end = interval_end(ray);
  visit(ray, 0.0, t_end, [&](std::uint32_t prim_id) {
    found = Crossing::find(ray, mesh_.triangle(prim_id)).has_value();
    return !found;
  });
  return found;
}

std::optional<ExactPoint> ExactOracle::point(const Ray& ray, std::uint32_t prim_id) const {
  const Triangle triangle = mesh_.triangle(prim_id);
  if (!is_traceable(ray) || !in_range(triangle)) return std::nullopt;
  const ExactCrossing exact = exact_crossing(ray, triangle);
  if (exact.det == 0) return std::nullopt;
  return ExactPoint{to_double(exact.t()), to_double(exact.weight(exact.v)), to_double(exact.weight(exact.w))};
}

std::vector<std::uint32_t> ExactOracle::near(const Ray& ray, double padding, double t_end) const {
  std::vector<std::uint32_t> prims;
  visit(ray, padding, t_end, [&](std::uint32_t prim_id) {
    prims.push_back(prim_id);
    return true;
  });
  std::sort(prims.begin(), prims.end());
  return prims;
}

bool ExactOracle::can_be_hit(std::uint32_t prim_id) const {
  const Triangle triangle = mesh_.triangle(prim_id);
  return in_range(triangle) && !has_zero_area(triangle);
}

}  // namespace accel::validation
