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
  static std::optional<Crossing> find(const Ray& ray, const PlacedTriangle& triangle) {
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
  Crossing(const PlacedTriangle& triangle, double t_lo, double t_hi) : triangle_(triangle), t_lo_(t_lo), t_hi_(t_hi) {}

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

  PlacedTriangle triangle_;
  double t_lo_, t_hi_;
  std::optional<ExactRatio> exact_;
};

// How far a movement of 1 in each instance's space reaches in the world along an axis, relative to distances in the world: a
// difference d becomes at most sum_j |L_ij| |d_j| there, and |M| times that back here. Distances are those of triangles from
// the origin, and, as a length, of triangles from what the map takes to zero.
TriangleTree::Padding unit_padding(const InstancedMeshes& scene) {
  TriangleTree::Padding result{1, 0};
  double farthest = 0;
  for (std::size_t i = 0; i < scene.instances().size(); ++i) {
    const Instance& instance = scene.instances()[i];
    const LinearInverse inverse = *invert_linear(instance.transform);
    for (int a = 0; a < 3; ++a) {
      double spread = 0;
      for (int b = 0; b < 3; ++b)
        for (int c = 0; c < 3; ++c) spread += std::abs(instance.transform.m[a][b] * inverse.m[b][c]);
      result.share = std::max(result.share, spread);
    }
    for (const Vec3 v : scene.meshes()[instance.mesh].vertices) {
      if (!accel::in_range(v)) continue;
      const Vec3d p = transform_point(instance.transform, Vec3d(v)) - Vec3d(instance.transform.translation());
      farthest = std::max({farthest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
  }
  result.length = result.share * farthest;
  return result;
}

}  // namespace

bool ExactHit::contains(std::uint32_t prim_id) const { return std::binary_search(prims.begin(), prims.end(), prim_id); }

ExactOracle::ExactOracle(const TriangleMesh& mesh, Search search)
    : mesh_(mesh), search_(search), tree_(search == Search::tree ? mesh : TriangleMesh{}) {}

ExactOracle::ExactOracle(const InstancedMeshes& scene, Search search)
    : instances_(scene),
      search_(search),
      tree_(search == Search::tree ? scene : InstancedMeshes()),
      unit_padding_(unit_padding(scene)) {}

const Instance* ExactOracle::instance_of(std::uint32_t prim_id) const {
  return instances_ ? &instances_->instances()[instance_number(prim_id)] : nullptr;
}

std::uint32_t ExactOracle::instance_number(std::uint32_t prim_id) const {
  return instances_ ? instances_->place_of(prim_id).instance : 0;
}

Triangle ExactOracle::local_triangle(std::uint32_t prim_id) const {
  if (!instances_) return mesh_.triangle(prim_id);
  const InstancedMeshes::Place place = instances_->place_of(prim_id);
  return instances_->meshes()[instances_->instances()[place.instance].mesh].triangle(place.triangle);
}

bool ExactOracle::is_known(std::uint32_t prim_id) const {
  return prim_id < triangles().size() && in_range(local_triangle(prim_id));
}

PlacedTriangle ExactOracle::placed(std::uint32_t prim_id) const {
  if (!instances_) return mesh_.triangle(prim_id);
  const InstancedMeshes::Place place = instances_->place_of(prim_id);
  const Instance& instance = instances_->instances()[place.instance];
  return {instances_->meshes()[instance.mesh].triangle(place.triangle), &instance.transform};
}

template <class Visit>
void ExactOracle::visit(const Ray& ray, TriangleTree::Padding padding, double& t_end, Visit&& visit) const {
  if (!is_traceable(ray)) return;
  if (search_ == Search::tree) {
    // Boxes before the interval are of interest when they are inflated, since rounding may move a hit into it.
    tree_.visit(ray, padding, interval_begin(ray), t_end, visit);
    return;
  }
  for (std::uint64_t i = 0; i < triangles().size(); ++i) {
    const auto prim_id = static_cast<std::uint32_t>(i);
    if (in_range(local_triangle(prim_id)) && !visit(prim_id)) return;
  }
}

ExactHit ExactOracle::closest(const Ray& ray) const {
  ExactHit hit;
  std::optional<Crossing> best;
  double t_end = interval_end(ray);
  visit(ray, {}, t_end, [&](std::uint32_t prim_id) {
    std::optional<Crossing> crossing = Crossing::find(ray, placed(prim_id));
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
  visit(ray, {}, t_end, [&](std::uint32_t prim_id) {
    found = Crossing::find(ray, placed(prim_id)).has_value();
    return !found;
  });
  return found;
}

std::optional<ExactPoint> ExactOracle::point(const Ray& ray, std::uint32_t prim_id) const {
  if (!is_traceable(ray) || !in_range(local_triangle(prim_id))) return std::nullopt;
  const ExactCrossing exact = exact_crossing(ray, placed(prim_id));
  if (exact.det == 0) return std::nullopt;
  return ExactPoint{to_double(exact.t()), to_double(exact.weight(exact.v)), to_double(exact.weight(exact.w))};
}

std::vector<std::uint32_t> ExactOracle::near(const Ray& ray, double padding, double t_end) const {
  std::vector<std::uint32_t> prims;
  visit(ray, {padding * unit_padding_.share, padding * unit_padding_.length}, t_end, [&](std::uint32_t prim_id) {
    prims.push_back(prim_id);
    return true;
  });
  std::sort(prims.begin(), prims.end());
  return prims;
}

bool ExactOracle::can_be_hit(std::uint32_t prim_id) const {
  // A map with an inverse keeps what has an area from losing it, and the other way round.
  const Triangle triangle = local_triangle(prim_id);
  return in_range(triangle) && !has_zero_area(triangle);
}

}  // namespace accel::validation
