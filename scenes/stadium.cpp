// The teapot in the stadium: a coarse oval arena, some 250 m long on a plain of 800 m, with rows of seats, pillars and a
// lattice roof, and in its middle a few sculptures of some metres that hold most of the triangles. Grids starve here, trees do
// not.
//
// Metres; y is up, the long axis is x. About a quarter of the triangles are seats, most of the others sculptures.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "scenes/generators.h"
#include "scenes/mesh_builder.h"
#include "scenes/noise.h"

namespace accel {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kPitchX = 58, kPitchZ = 40;  // half axes of the pitch

// The point `out` metres outside the edge of the pitch, at height y, `u` of a turn round.
Vec3d on_oval(double u, double out, double y) {
  return {(kPitchX + out) * std::cos(kTurn * u), y, -(kPitchZ + out) * std::sin(kTurn * u)};
}

// A corner of the cross-section of the stands.
struct Corner {
  double out, y;
};

// What the size decides about the arena.
struct Arena {
  std::uint32_t segments, lower_rows, upper_rows, seats_per_row;

  explicit Arena(double size) {
    const double root = std::sqrt(size);
    segments = static_cast<std::uint32_t>(std::clamp(root / 6, 12.0, 144.0));
    lower_rows = static_cast<std::uint32_t>(std::clamp(root / 25, 2.0, 24.0));
    upper_rows = static_cast<std::uint32_t>(std::clamp(root / 25, 2.0, 22.0));
    seats_per_row = static_cast<std::uint32_t>(size / 4 / (4 * (lower_rows + upper_rows)));
  }
};

constexpr double kLowerDepth = 20, kLowerFoot = 1.4, kLowerTop = 11;  // the lower tier, from the edge of the pitch
constexpr double kUpperStart = 22, kUpperDepth = 18, kUpperFoot = 14.5, kUpperTop = 28;
constexpr double kRim = kUpperStart + kUpperDepth + 1.5, kRoof = 37;  // the outer wall, and the height of the roof

// A seat row's place: the front edge of its tread.
struct Row {
  double out, y, depth;
};

std::vector<Row> seat_rows(const Arena& arena) {
  std::vector<Row> rows;
  const auto add_tier = [&](std::uint32_t count, double start, double depth, double foot, double top) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const double share = static_cast<double>(i) / count;
      rows.push_back({start + depth * share, foot + (top - foot) * share, depth / count});
    }
  };
  add_tier(arena.lower_rows, 0, kLowerDepth, kLowerFoot, kLowerTop);
  add_tier(arena.upper_rows, kUpperStart, kUpperDepth, kUpperFoot, kUpperTop);
  return rows;
}

// Sweeps a cross-section round the oval.
void add_sweep(MeshBuilder& builder, std::vector<Corner> section, std::uint32_t segments) {
  const auto rows = static_cast<std::uint32_t>(section.size() - 1);
  builder.add_grid(segments, rows, GridShape::tube, [=, section = std::move(section)](double u, double v) {
    const Corner& c = section[static_cast<std::size_t>(std::lround(v * rows))];
    return on_oval(u, c.out, c.y);
  });
}

void add_stands(MeshBuilder& builder, const Arena& arena, const std::vector<Row>& rows) {
  std::vector<Corner> section{{0, 0}};
  for (const Row& row : rows) {
    section.push_back({row.out, row.y});
    section.push_back({row.out + row.depth, row.y});
    if (&row == &rows[arena.lower_rows - 1]) {
      section.push_back({row.out + row.depth, kLowerTop});
      section.push_back({kUpperStart, kLowerTop});
    }
  }
  section.insert(section.end(),
                 {{kRim - 1.5, kUpperTop}, {kRim, kUpperTop}, {kRim, kUpperTop + 2}, {kRim + 1, kUpperTop + 2}, {kRim + 6, 0}});
  add_sweep(builder, std::move(section), arena.segments);
}

// A seat: a pan and a back of two triangles each, on six vertices. Every sixteenth is left out for an aisle.
void add_seats(MeshBuilder& builder, const Row& row, std::uint32_t places) {
  const std::uint32_t seats = places - places / 16;
  const auto vertex = [=](std::uint32_t i) {
    const std::uint32_t seat = i / 6, corner = i % 6, place = seat + seat / 15;
    const double u = (place + (corner % 2 == 0 ? 0.14 : 0.86)) / places;
    const double front = row.out + 0.45 * row.depth, back = row.out + 0.85 * row.depth;
    const std::uint32_t edge = corner / 2;  // front of the pan, fold, top of the back
    return on_oval(u,
                   edge == 0   ? front
                   : edge == 1 ? back
                               : back + 0.1 * row.depth,
                   row.y + (edge == 0   ? 0.42
                            : edge == 1 ? 0.38
                                        : 0.85));
  };
  const auto triangle = [](std::uint32_t i) {
    static constexpr IndexTriple kSeat[4] = {{0, 1, 3}, {0, 3, 2}, {2, 3, 5}, {2, 5, 4}};
    const IndexTriple t = kSeat[i % 4];
    const std::uint32_t base = i / 4 * 6;
    return IndexTriple{base + t.v0, base + t.v1, base + t.v2};
  };
  builder.add(6ull * seats, 4ull * seats, vertex, triangle);
}

// A straight tube of `sides` sides between two points.
void add_tube(MeshBuilder& builder, Vec3d from, Vec3d to, double radius, std::uint32_t sides) {
  Vec3d x, y;
  make_basis(normalized(to - from), x, y);
  builder.add_grid(sides, 1, GridShape::tube, [=](double u, double v) {
    return from * (1 - v) + to * v + (x * std::cos(kTurn * u) + y * std::sin(kTurn * u)) * radius;
  });
}

// The roof: a thin ring that rises inwards, carried by pillars and a lattice of tubes below it.
void add_roof(MeshBuilder& builder, const Arena& arena) {
  const double inner = kRim - 27, edge = kRoof + 3.5;
  add_sweep(builder, {{inner, edge}, {inner, edge + 0.8}, {kRim + 5, kRoof + 0.5}, {kRim + 5, kRoof}, {inner, edge}},
            arena.segments);

  const std::uint32_t bays = arena.segments / 2, sides = arena.segments >= 48 ? 10 : 4;
  const auto under = [&](double u, double out, double drop) {
    const double share = (out - inner) / (kRim + 5 - inner);
    return on_oval(u, out, edge + (kRoof - edge) * share - drop);
  };
  for (std::uint32_t i = 0; i < bays; ++i) {
    const double u = static_cast<double>(i) / bays, next = static_cast<double>(i + 1) / bays, half = (u + next) / 2;
    add_tube(builder, on_oval(u, kRim - 0.5, kUpperTop), under(u, kRim - 0.5, 0), 0.45, sides);  // pillar
    add_tube(builder, on_oval(u, kUpperStart - 0.7, kLowerTop), on_oval(u, kUpperStart - 0.2, kUpperFoot), 0.3, sides);
    add_tube(builder, under(u, kRim, 1.0), under(u, inner + 0.5, 0.6), 0.3, sides);        // rib
    add_tube(builder, under(u, kRim - 1, 0.8), under(half, kRim - 13, 0.8), 0.16, sides);  // lattice
    add_tube(builder, under(next, kRim - 1, 0.8), under(half, kRim - 13, 0.8), 0.16, sides);
    add_tube(builder, under(half, kRim - 13, 0.8), under(u, inner + 0.5, 0.6), 0.16, sides);
    add_tube(builder, under(half, kRim - 13, 0.8), under(next, inner + 0.5, 0.6), 0.16, sides);
  }
}

// A round base of steps, closed on top.
void add_podium(MeshBuilder& builder, Vec3d foot, double radius, double step, double height, int steps, std::uint32_t sides) {
  std::vector<ProfilePoint> profile;
  for (int i = 0; i < steps; ++i) {
    profile.push_back({radius - i * step, height * i / steps});
    profile.push_back({radius - i * step, height * (i + 1) / steps});
  }
  const double top = radius - (steps - 1) * step;
  builder.add_lathe(foot, std::move(profile), sides);
  builder.add_disk(foot + Vec3d{0, height, 0}, top, top, sides);
}

// A closed tube about the (2, 3) torus knot, fluted and twisted. Its axis lies on a torus about y with radii 2 and 1, whose
// normal steers the frame of the cross-section.
void add_knot(MeshBuilder& builder, Vec3d center, double scale, double budget) {
  const auto axis = [](double s) {
    const double ring = 2 + std::cos(3 * s);
    return Vec3d{ring * std::cos(2 * s), ring * std::sin(2 * s), std::sin(3 * s)};
  };
  const std::uint32_t columns = std::max(3u, steps_for(budget, 2 * 9.0)), rows = 9 * columns;
  builder.add_grid(columns, rows, GridShape::torus, [=](double u, double v) {
    const double s = kTurn * v;
    const Vec3d along = normalized(axis(s + 1e-4) - axis(s - 1e-4));
    const Vec3d outwards{std::cos(3 * s) * std::cos(2 * s), std::cos(3 * s) * std::sin(2 * s), std::sin(3 * s)};
    const Vec3d across = normalized(cross(along, outwards)), up = cross(across, along);
    const double angle = kTurn * u, radius = 0.42 * (1 + 0.10 * std::cos(7 * angle + 42 * s));
    return center + (axis(s) + (across * std::cos(angle) + up * std::sin(angle)) * radius) * scale;
  });
}

// A ring whose cross-section is a rounded square that turns twice on its way round.
void add_twisted_ring(MeshBuilder& builder, Vec3d center, double scale, double budget) {
  const std::uint32_t columns = std::max(4u, steps_for(budget, 2 * 3.0)), rows = 3 * columns;
  builder.add_grid(columns, rows, GridShape::torus, [=](double u, double v) {
    const double around = kTurn * v, angle = kTurn * u, turned = angle + 2 * around;
    const double c = std::cos(angle), s = std::sin(angle), radius = 0.48 / std::pow(std::pow(c, 6) + std::pow(s, 6), 1 / 6.0);
    const double out = 1.35 + radius * std::cos(turned), side = radius * std::sin(turned);
    return center + Vec3d{out * std::cos(around), out * std::sin(around), side} * scale;
  });
}

// A sphere that noise has pulled into hills and folds.
void add_pebble(MeshBuilder& builder, Vec3d center, double radius, double budget, std::uint64_t seed) {
  builder.add_sphere(std::max(2u, steps_for(budget, 8)), [=](Vec3d unit) {
    const Vec3d bent = unit + Vec3d{noise(unit * 1.7, seed), noise(unit * 1.7, seed + 1), noise(unit * 1.7, seed + 2)} * 0.5;
    const double folds = 0.5 + 0.5 * std::sin(8 * fractal_noise(bent * 1.3, 2, seed + 3));
    return center + unit * (radius * (0.92 + 0.14 * folds * folds + 0.03 * fractal_noise(bent * 7, 4, seed + 9)));
  });
}

void add_sculptures(MeshBuilder& builder, double budget, std::uint32_t sides, std::uint64_t seed) {
  constexpr int kPearls = 24;
  const Vec3d middle{0, 0, 0}, left{-10.5, 0, 4.5}, right{10.5, 0, 3.5};
  add_podium(builder, middle, 17, 1.2, 1.2, 4, sides);
  add_podium(builder, middle + Vec3d{0, 1.2, 0}, 3.2, 0.5, 1.6, 3, sides);
  add_podium(builder, left + Vec3d{0, 1.2, 0}, 2.2, 0.4, 1.4, 2, sides);
  add_podium(builder, right + Vec3d{0, 1.2, 0}, 2.2, 0.4, 1.4, 2, sides);

  add_knot(builder, middle + Vec3d{0, 8.4, 0}, 1.65, 0.45 * budget);
  add_pebble(builder, left + Vec3d{0, 4.9, 0}, 2.3, 0.25 * budget, seed);
  add_twisted_ring(builder, right + Vec3d{0, 5.35, 0}, 1.55, 0.18 * budget);
  for (int i = 0; i < kPearls; ++i) {
    const double angle = kTurn * (i + 0.5) / kPearls;
    const Vec3d center{15.2 * std::cos(angle), 1.05, 15.2 * std::sin(angle)};
    builder.add_sphere(steps_for(0.12 * budget / kPearls, 8), [=](Vec3d unit) { return center + unit * 0.75; });
  }
}

}  // namespace

SceneData make_stadium(std::uint64_t size, std::uint64_t seed) {
  const Arena arena(static_cast<double>(size));
  MeshBuilder builder;
  builder.add_quad({-400, -0.5, 400}, {400, -0.5, 400}, {400, -0.5, -400}, {-400, -0.5, -400});
  builder.add_disk({0, 0, 0}, kPitchX, kPitchZ, arena.segments);
  const std::vector<Row> rows = seat_rows(arena);
  add_stands(builder, arena, rows);
  add_roof(builder, arena);
  if (arena.seats_per_row >= 16)
    for (const Row& row : rows) add_seats(builder, row, arena.seats_per_row);

  // What the arena leaves goes into the sculptures.
  const double left = static_cast<double>(size) - static_cast<double>(builder.triangle_count());
  add_sculptures(builder, std::max(left, 0.0), std::max(12u, arena.segments / 2 * 2), seed);
  return {builder.build(),
          {{{7, 4.2f, 31}, {0, 7.2f, 0}, {0, 1, 0}, 46, "default"}, {{-75, 24, 40}, {0, 5, 0}, {0, 1, 0}, 52, "stands"}},
          LightDescription{{12, 34, 14}, {4, 0, 0}, {0, 0, 4}}};
}

}  // namespace accel
