// A vaulted hall between two rows of fluted columns: axis-aligned walls and steps beside finely curved shafts, as in
// architecture.
//
// Metres; y is up, the hall runs along z from 0 (the viewer's end) to -kHallLength. Walls and steps are a few hundred
// triangles; the columns, arches and the vault share the rest.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "scenes/generators.h"
#include "scenes/mesh_builder.h"

namespace accel {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kBays = 9;  // between kBays + 1 columns on either side
constexpr double kBay = 5, kHallLength = kBays * kBay;
constexpr double kAisle = 5;    // half the width of the nave: where the columns stand
constexpr double kWall = 9;     // half the width of the hall
constexpr double kShaft = 6.2;  // height of a shaft
constexpr double kBase = 0.5, kCapital = 0.6;
constexpr double kSpring = kBase + kShaft + kCapital;  // where the arches start
constexpr double kCrown = kSpring + kBay / 2 + 0.8;    // where the vault starts
constexpr double kThick = 0.55;                        // half the thickness of the arcade wall

// A fluted shaft that swells a little below its middle and narrows to the top, between a round base and a round capital.
double shaft_radius(double height, double angle) {
  const double share = height / kShaft;
  const double body = 0.5 - 0.07 * share * share;
  const double flute = 0.035 * std::pow(std::fabs(std::sin(10 * angle)), 0.7);
  const double ends = std::clamp(std::min(share, 1 - share) * 25, 0.0, 1.0);
  return body - 0.035 * ends + flute * ends;
}

void add_column(MeshBuilder& builder, Vec3d foot, std::uint32_t sides, std::uint32_t rows) {
  builder.add_box(foot + Vec3d{-0.75, 0, -0.75}, foot + Vec3d{0.75, 0.2, 0.75});
  const double top = kSpring - 0.25;
  builder.add_box(foot + Vec3d{-0.7, top, -0.7}, foot + Vec3d{0.7, kSpring, 0.7});

  // Base and capital: quarter rounds.
  std::vector<ProfilePoint> base, capital;
  const int steps = static_cast<int>(std::clamp(rows / 4, 2u, 24u));
  for (int i = 0; i <= steps; ++i) {
    const double angle = kPi * i / steps - kPi / 2, quarter = kPi / 2 * i / steps;
    base.push_back({0.52 + 0.15 * std::cos(angle), 0.35 + 0.15 * std::sin(angle)});
    capital.push_back({0.43 + 0.27 * (1 - std::cos(quarter)), kBase + kShaft + (kCapital - 0.25) * std::sin(quarter)});
  }
  builder.add_lathe(foot, std::move(base), sides);
  builder.add_lathe(foot, std::move(capital), sides);

  builder.add_grid(sides, rows, GridShape::tube, [=](double u, double v) {
    const double angle = -2 * kPi * u, height = v * kShaft, radius = shaft_radius(height, angle);
    return foot + Vec3d{radius * std::cos(angle), kBase + height, radius * std::sin(angle)};
  });
}

// The wall over one bay of the arcade: its two faces between the arch and the cornice, and the moulded inside of the arch.
void add_arch(MeshBuilder& builder, double x, double z, std::uint32_t steps) {
  const double radius = kBay / 2 - 0.45;
  const auto on_arch = [=](double u, double r, double px) {
    const double angle = kPi * u;
    return Vec3d{px, kSpring + r * std::sin(angle), z + r * std::cos(angle)};
  };
  for (const double side : {-1.0, 1.0}) {
    const double face = x + side * kThick;
    builder.add_grid(steps, 1, GridShape::open, [=](double u, double v) {
      const Vec3d low = on_arch(u, radius, face);
      const Vec3d high{face, kCrown, z + kBay / 2 * std::cos(kPi * u)};
      return v == 0 ? low : high;
    });
    for (const double end : {-1.0, 1.0}) {
      const double column = z + end * kBay / 2;
      builder.add_triangle({face, kSpring, column}, {face, kSpring, z + end * radius}, {face, kCrown, column});
    }
  }
  const std::uint32_t across = std::max(2u, steps / 4);
  builder.add_grid(steps, across, GridShape::open, [=](double u, double v) {
    const double roll = 0.08 * std::fabs(std::sin(3 * kPi * v));
    return on_arch(u, radius - roll, x + kThick * (2 * v - 1));
  });
}

// The barrel vault over the nave, with ribs that stand out at the columns and coffers between them.
void add_vault(MeshBuilder& builder, std::uint32_t around, std::uint32_t along) {
  builder.add_grid(around, along, GridShape::open, [=](double u, double v) {
    const auto bulge = [](double t) { return std::clamp(6 * (std::fabs(std::sin(kPi * t)) - 0.35), 0.0, 1.0); };
    const double radius = kAisle + 0.35 * bulge(kBays * v) * bulge(8 * u) - 0.35;
    const double angle = kPi * u;
    return Vec3d{radius * std::cos(angle), kCrown + 0.85 * radius * std::sin(angle), -kHallLength * v};
  });
}

// Floor, outer walls with a bench, aisle ceilings, the end wall and the steps in front of it.
void add_walls(MeshBuilder& builder) {
  builder.add_quad({-kWall, 0, 3}, {kWall, 0, 3}, {kWall, 0, -kHallLength - 6}, {-kWall, 0, -kHallLength - 6});
  for (const double side : {-1.0, 1.0}) {
    const double wall = side * kWall, inner = side * (kAisle + kThick);
    builder.add_quad({wall, 0, 3}, {wall, 0, -kHallLength - 6}, {wall, kCrown, -kHallLength - 6}, {wall, kCrown, 3});
    builder.add_quad({wall, kCrown, 3}, {wall, kCrown, -kHallLength - 6}, {inner, kCrown, -kHallLength}, {inner, kCrown, 0});
    builder.add_box({std::min(wall, wall - side * 0.8), 0, -kHallLength}, {std::max(wall, wall - side * 0.8), 0.5, 0});
    builder.add_box({side * kAisle - kThick - 0.1, kCrown - 0.25, -kHallLength},
                    {side * kAisle + kThick + 0.1, kCrown, 0});  // cornice
    for (int bay = 0; bay < kBays; ++bay) {
      const double z = -kBay * (bay + 0.5);
      builder.add_box({std::min(wall, wall - side * 0.25), 1.2, z - 1.1}, {std::max(wall, wall - side * 0.25), 1.4, z + 1.1});
      builder.add_box({std::min(wall, wall - side * 0.15), 1.4, z - 0.9}, {std::max(wall, wall - side * 0.15), 5.6, z - 0.7});
      builder.add_box({std::min(wall, wall - side * 0.15), 1.4, z + 0.7}, {std::max(wall, wall - side * 0.15), 5.6, z + 0.9});
      builder.add_box({std::min(wall, wall - side * 0.25), 5.6, z - 1.1}, {std::max(wall, wall - side * 0.25), 5.9, z + 1.1});
    }
  }
  const double end = -kHallLength - 6;
  builder.add_quad({-kWall, 0, end}, {kWall, 0, end}, {kWall, kCrown + kAisle, end}, {-kWall, kCrown + kAisle, end});
  for (int i = 0; i < 5; ++i) builder.add_box({-kAisle, 0.2 * i, end}, {kAisle, 0.2 * (i + 1), -kHallLength + 0.5 * i});
}

}  // namespace

SceneData make_colonnade(std::uint64_t size, std::uint64_t) {
  MeshBuilder builder;
  add_walls(builder);

  // Shares of what is left: 65 % columns, 20 % vault, 10 % arches, 5 % the sphere on the steps.
  const double left = std::max(0.0, static_cast<double>(size) - static_cast<double>(builder.triangle_count()));
  const std::uint32_t columns = 2 * (kBays + 1);
  const std::uint32_t sides = std::max(6u, steps_for(0.65 * left / columns, 2.0));
  const auto rows = static_cast<std::uint32_t>(std::max(1.0, std::round((0.65 * left / columns / 2 - 24.0) / sides / 1.4)));
  const std::uint32_t arch = std::max(4u, steps_for(0.10 * left / (2 * kBays), 0.5));
  for (const double side : {-1.0, 1.0}) {
    for (int i = 0; i <= kBays; ++i) add_column(builder, {side * kAisle, 0, -kBay * i}, sides, rows);
    for (int i = 0; i < kBays; ++i) add_arch(builder, side * kAisle, -kBay * (i + 0.5), arch);
  }
  const std::uint32_t around = std::max(4u, steps_for(0.20 * left, 4));
  add_vault(builder, around, 2 * around);
  const Vec3d center{0, 2.6, -kHallLength - 3};
  builder.add_sphere(std::max(2u, steps_for(0.05 * left, 8)), [=](Vec3d unit) { return center + unit * 1.6; });

  const CameraDescription view{{-2.2f, 1.9f, 1.5f}, {1.2f, 4.3f, -18}, {0, 1, 0}, 58, "default"};
  return {builder.build(), {view}, LightDescription{{0, 9, -15}, {1.5f, 0, 0}, {0, 0, 1.5f}}};
}

}  // namespace accel
