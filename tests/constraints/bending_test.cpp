// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/bending.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/constraints/distance.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "tests/support/bending_hinge.h"
#include "tests/support/catch.h"
#include "tests/support/constraint_checks.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::Hinge;
using testing::kPi;
using testing::random_point;
using testing::turn_of;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

template <class Scalar>
double largest_move(const Hinge<Scalar>& a, const Hinge<Scalar>& b) {
  double square = 0;
  for (int i = 0; i < 4; ++i) {
    const Vec3<Scalar> d = a.x[i] - b.x[i];
    square = std::max<double>(square, dot(d, d));
  }
  return std::sqrt(square);
}

// To (-pi, pi].
double wrapped(double angle) {
  return angle - 2 * kPi * std::ceil(angle / (2 * kPi) - 0.5);
}

}  // namespace

TEST_CASE("bending constraint: gradient, scale, momentum, frame and compliance", "[property]") {
  testing::check_all<BendingConstraint>();
}

// Would catch a wrong sign, a range of half the circle only, and a rest angle that is taken off
// where it must be turned off.
TEST_CASE("bending constraint: its value is the turn from rest, the shorter way", "[property]") {
  const double edge = GENERATE(1.0, 1e-4);
  const double angle = GENERATE(-3.1, -2.0, -0.5, -1e-7, 0.0, 1e-7, 0.1, 1.0, 2.5, 3.1);
  const double rest = GENERATE(-3.1, -1.2, 0.0, 0.4, 2.0, 3.1);
  const Hinge hinge(edge, angle);

  CHECK(hinge.value(turn_of(rest)) ==
        Approx(turn_of(wrapped(angle - rest))).epsilon(1e-9).margin(1e-12));
  // in single precision the angle of normals is as exact as the normals
  CHECK(Hinge<float>(edge, angle).value(turn_of(rest)) ==
        Approx(turn_of(wrapped(angle - rest))).margin(1e-5));
}

TEST_CASE("bending constraint: convex towards the normals is positive", "[unit]") {
  const Vec3<double> ridge[4] = {{0, 0, 0}, {0, 1, 0}, {-1, 0, -1}, {1, 0, -1}};
  CHECK(BendingConstraint::value(ridge, 0.0) == Approx(turn_of(kPi / 2)));
}

TEST_CASE("bending constraint: gradients are those of the value at any angle and rest",
          "[property]") {
  const double edge = GENERATE(1.0, 1e-4);
  const double angle = GENERATE(-3.0, -1.0, 0.0, 0.7, 3.0);
  const double rest = turn_of(GENERATE(-2.9, 0.0, 1.0));
  const Hinge hinge(edge, angle);
  const auto turn = BendingConstraint::turn(hinge.x, rest);
  const double step = 1e-5 * edge;
  for (int i = 0; i < 4; ++i) {
    for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
      Hinge low = hinge, high = hinge;
      low.x[i].*axis -= step;
      high.x[i].*axis += step;
      CHECK(edge * turn.gradient[i].*axis ==
            Approx(edge * (high.value(rest) - low.value(rest)) / (2 * step)).margin(1e-7));
    }
  }
}

TEST_CASE("bending constraint: a hinge at rest stays, whatever its angle", "[property]") {
  const double edge = GENERATE(1e-1, 1e-4);
  const double angle = GENERATE(-3.14, -1.5, 0.0, 0.2, 3.0, kPi);
  Hinge hinge(edge, angle);
  const HingeAtRest rest = hinge_at_rest(hinge.x, 1e-6);
  CHECK(std::abs(hinge.value(rest.turn)) < 1e-14);
  const Hinge before = hinge;
  hinge.project<ProjectionMode::fraction>(rest.turn, 1);
  hinge.project<ProjectionMode::compliance>(rest.turn, 0);
  CHECK(largest_move(hinge, before) < 1e-14 * edge);

  Hinge<float> single(edge, angle);
  const Hinge<float> single_before = single;
  single.project<ProjectionMode::fraction>(rest.turn, 1);
  CHECK(largest_move(single, single_before) < 1e-6 * edge);
}

// Would catch a gradient that vanishes or explodes where the triangles meet, and a hinge that a
// turn through itself leaves there.
TEST_CASE("bending constraint: a folded hinge opens", "[property]") {
  const double edge = GENERATE(1e-2, 1e-4);
  const double angle = GENERATE(-kPi, -3.141, 3.0, 3.14159, kPi);
  const double rest = turn_of(GENERATE(-0.5, 0.0, 0.5));
  const double fraction = GENERATE(0.1, 1.0);
  Hinge<float> hinge(edge, angle);
  for (int i = 0; i < 200; ++i) {
    const Hinge<float> before = hinge;
    hinge.project<ProjectionMode::fraction>(rest, fraction);
    REQUIRE(largest_move(hinge, before) < 5 * edge);
  }
  CHECK(std::abs(hinge.value(rest)) < 1e-4);
}

TEST_CASE("bending constraint: triangles without area are not pushed", "[unit]") {
  const auto check = [](auto zero) {
    using Scalar = decltype(zero);
    const auto shape = GENERATE(0, 1, 2, 3, 4);
    Hinge<Scalar> hinge(1e-3, 0.5);
    if (shape == 0) {
      hinge.x[2] = hinge.x[0];
    } else if (shape == 1) {
      hinge.x[3] = hinge.x[1];
    } else if (shape == 2) {  // on the line through the edge
      hinge.x[0] = {0, 0, 0};
      hinge.x[1] = {1, 0, 0};
      hinge.x[3] = {Scalar(0.25), 0, 0};
    } else if (shape == 3) {
      hinge.x[1] = hinge.x[0];
    } else {
      hinge.x[1] = hinge.x[2] = hinge.x[3] = hinge.x[0];
    }
    const Hinge<Scalar> before = hinge;
    CHECK(hinge.value(1) == 0);
    CHECK(hinge.template project<ProjectionMode::fraction>(1, 1) == 0);
    CHECK(hinge.template project<ProjectionMode::compliance>(1, 0) == 0);
    CHECK(hinge.is_same_as(before));

    VertexEnergy<Scalar> energy;
    energy.add_hinge(Scalar(1), Scalar(1), hinge.x, shape % 2 == 0);
    CHECK(energy.isotropic == 0);
    CHECK(energy.xx + energy.yy + energy.zz == 0);
    CHECK(dot(energy.force, energy.force) == 0);
  };
  SECTION("float") {
    check(0.0F);
  }
  SECTION("double") {
    check(0.0);
  }
}

// Would catch a push of a nearly straight triangle that grows as its height shrinks.
TEST_CASE("bending constraint: a sliver moves by no more than its size", "[property]") {
  const double height = GENERATE(1e-2, 1e-4, 1e-6);
  Hinge<float> hinge(1e-3, 0.5);
  const Vec3<float> foot = hinge.x[0] + 0.4F * (hinge.x[1] - hinge.x[0]);
  hinge.x[2] = foot + static_cast<float>(height) * (hinge.x[2] - foot);
  const Hinge<float> before = hinge;
  hinge.project<ProjectionMode::fraction>(turn_of(-2), 1);
  CHECK(largest_move(hinge, before) < 5e-3 * height);
}

TEST_CASE("bending constraint: what is fixed or not finite moves nothing", "[unit]") {
  Hinge<float> fixed(1e-3, 0.5);
  fixed.w[1] = fixed.w[2] = 0;
  const Hinge<float> before = fixed;
  fixed.project<ProjectionMode::compliance>(0, 0);
  CHECK(fixed.x[1].x == before.x[1].x);
  CHECK(fixed.x[2].y == before.x[2].y);
  CHECK(fixed.x[3].y != before.x[3].y);

  const double bad = GENERATE(as<double>(), kNotANumber, kInfinite);
  const int which = GENERATE(0, 1, 2, 3);
  Hinge<float> broken(1e-3, 0.5);
  broken.x[which].y = static_cast<float>(bad);
  const Hinge<float> broken_before = broken;
  CHECK(broken.project<ProjectionMode::fraction>(0, 1) == 0);
  CHECK(std::isnan(broken.value()));
  VertexEnergy<float> energy;
  energy.add_hinge(1.0F, 0.0F, broken.x, which % 2 == 0);
  CHECK(energy.isotropic == 0);
  CHECK(dot(energy.force, energy.force) == 0);
  for (int i = 0; i < 4; ++i) {
    if (i != which) {
      CHECK(dot(broken.x[i] - broken_before.x[i], broken.x[i] - broken_before.x[i]) == 0);
    }
  }
}

// Rigid and at its rest angle, but turning: friction takes the share c / (1 + c) of the turn back.
TEST_CASE("bending constraint: damping resists the rate of the angle", "[unit]") {
  const double c = GENERATE(0.1, 1.0, 10.0);
  const double dt = 1e-3;
  Hinge start(1e-3, 0.8);
  Hinge hinge(1e-3, 0.8 + 1e-5);
  const double parameters[] = {hinge.value(), 0, c * dt};
  double multiplier[] = {0};
  Damped<double, 4> damping;
  std::copy(std::begin(start.x), std::end(start.x), damping.start);
  const double rest = hinge.value();
  const double turned = -start.value(rest);

  BendingConstraint::project<ProjectionMode::compliance>(
      hinge.x, hinge.w, parameters, Substep<double>{1 / dt, 1 / (dt * dt)}, multiplier, damping);

  CHECK(hinge.value(rest) == Approx(-c / (1 + c) * turned).epsilon(1e-3));
}

TEST_CASE("bending constraint: a rest shape that is not a hinge is refused", "[unit]") {
  const Hinge good(1e-3, 0.3);
  CHECK_NOTHROW(hinge_at_rest(good.x, 1e-9));
  const double rigidity = GENERATE(as<double>(), 0, -1, kNotANumber, kInfinite);
  CHECK_THROWS_AS(hinge_at_rest(good.x, rigidity), InvalidArgument);
  CHECK_THROWS_WITH(
      hinge_at_rest(good.x, -2),
      ContainsSubstring("flexural rigidity of a hinge is -2 N m") && ContainsSubstring("positive"));

  Hinge broken = good;
  broken.x[3].z = kNotANumber;
  CHECK_THROWS_WITH(hinge_at_rest(broken.x, 1), ContainsSubstring("vertex 3"));
  Hinge flat = good;
  flat.x[2] = flat.x[0] + 0.3 * (flat.x[1] - flat.x[0]);
  CHECK_THROWS_WITH(hinge_at_rest(flat.x, 1),
                    ContainsSubstring("height of vertex 2") && ContainsSubstring("1e-6"));
  Hinge closed = good;
  closed.x[1] = closed.x[0];
  CHECK_THROWS_WITH(hinge_at_rest(closed.x, 1), ContainsSubstring("edge of a hinge is 0 m"));
  // any size is as good as another
  for (const double scale : {1e-120, 1e120}) {
    Hinge scaled = good;
    for (Vec3<double>& x : scaled.x) {
      x = scale * x;
    }
    CHECK(hinge_at_rest(scaled.x, 1).turn == Approx(hinge_at_rest(good.x, 1).turn));
    CHECK(hinge_at_rest(scaled.x, 1).stiffness == Approx(hinge_at_rest(good.x, 1).stiffness));
  }
}

TEST_CASE("bending constraint: the flexural rigidity of a plate", "[unit]") {
  CHECK(flexural_rigidity(12e6, 1e-3, 0) == Approx(1e-3));
  CHECK(flexural_rigidity(12e6, 1e-3, 0.5) == Approx(1e-3 / 0.75));
  CHECK_THROWS_WITH(flexural_rigidity(0, 1, 0), ContainsSubstring("Young's modulus is 0 Pa"));
  CHECK_THROWS_WITH(flexural_rigidity(1, -1, 0), ContainsSubstring("thickness"));
  CHECK_THROWS_WITH(flexural_rigidity(1, 1, 0.51), ContainsSubstring("(-1, 0.5]"));
  CHECK_THROWS_AS(flexural_rigidity(1, 1, -1), InvalidArgument);
  CHECK_THROWS_AS(flexural_rigidity(1, 1, kNotANumber), InvalidArgument);
}

namespace {

constexpr double kRigidity = 2e-6;  // N m

struct Sheet {
  std::vector<Vec3<double>> points;           // m, flat, in the plane z = 0
  std::vector<std::array<int, 3>> triangles;  // counter-clockwise seen from +z
  [[nodiscard]] double area() const {
    double sum = 0;
    for (const auto& t : triangles) {
      sum += cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]).z / 2;
    }
    return sum;
  }
  [[nodiscard]] std::vector<std::array<int, 4>> hinges() const {
    std::map<std::pair<int, int>, int> opposite;  // of the directed edge
    for (const auto& t : triangles) {
      for (int i = 0; i < 3; ++i) {
        opposite[{t[i], t[(i + 1) % 3]}] = t[(i + 2) % 3];
      }
    }
    std::vector<std::array<int, 4>> result;
    for (const auto& [edge, left] : opposite) {
      const auto right = opposite.find({edge.second, edge.first});
      if (edge.first < edge.second && right != opposite.end()) {
        result.push_back({edge.first, edge.second, left, right->second});
      }
    }
    return result;
  }
};

// Equilateral triangles, or squares halved along one diagonal, over about `size` squared.
Sheet make_sheet(bool equilateral, int cells, double size) {
  Sheet sheet;
  const double h = size / cells;
  const double height = equilateral ? h * std::sqrt(3) / 2 : h;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      sheet.points.push_back({h * (i + (equilateral ? 0.5 * (j % 2) : 0)), height * j, 0});
    }
  }
  const auto id = [&](int i, int j) { return i + (cells + 1) * j; };
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      if (equilateral && j % 2 == 1) {
        sheet.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
        sheet.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
      } else {
        sheet.triangles.push_back({id(i, j), id(i + 1, j), id(i, j + 1)});
        sheet.triangles.push_back({id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)});
      }
    }
  }
  return sheet;
}

// Rolled without stretch onto a cylinder whose axis has this angle to the y axis.
std::vector<Vec3<double>> rolled(const Sheet& sheet, double curvature, double axis) {
  std::vector<Vec3<double>> result;
  for (const Vec3<double>& p : sheet.points) {
    const double along = p.x * std::cos(axis) + p.y * std::sin(axis);
    const double across = p.y * std::cos(axis) - p.x * std::sin(axis);
    result.push_back(curvature == 0 ? Vec3<double>{along, across, 0}
                                    : Vec3<double>{std::sin(curvature * along) / curvature, across,
                                                   (std::cos(curvature * along) - 1) / curvature});
  }
  return result;
}

double bending_energy(const Sheet& sheet, const std::vector<Vec3<double>>& rest,
                      const std::vector<Vec3<double>>& x) {
  double energy = 0;
  for (const auto& h : sheet.hinges()) {
    const Vec3<double> rest_hinge[4] = {rest[h[0]], rest[h[1]], rest[h[2]], rest[h[3]]};
    const Vec3<double> hinge[4] = {x[h[0]], x[h[1]], x[h[2]], x[h[3]]};
    const HingeAtRest at_rest = hinge_at_rest(rest_hinge, kRigidity);
    const double turn = BendingConstraint::value(hinge, at_rest.turn);
    energy += at_rest.stiffness / 2 * turn * turn;
  }
  return energy;
}

}  // namespace

// Would catch a wrong factor between a hinge's stiffness and the rigidity of the plate, one that
// depends on the size of the triangles, and a rest curvature that is not taken off. Edges at the
// rim have no hinge: the error is of the order of a triangle's share of the sheet.
TEST_CASE("bending constraint: a sheet bent to a cylinder stores D/2 curvature^2 per area",
          "[property]") {
  const double size = GENERATE(1.0, 2e-2);
  const double curvature = 1.5 / size;
  const double rest_curvature = GENERATE(0.0, -0.8, 1.0) / size;
  const bool equilateral = GENERATE(false, true);
  const double axis = equilateral ? GENERATE(0.0, 0.3, 0.5235987755982988, 1.2) : 0.0;
  double error = 1;
  for (const int cells : {8, 16, 32, 64}) {
    const Sheet sheet = make_sheet(equilateral, cells, size);
    const double expected = kRigidity / 2 * std::pow(curvature - rest_curvature, 2) * sheet.area();
    const double energy =
        bending_energy(sheet, rolled(sheet, rest_curvature, axis), rolled(sheet, curvature, axis));
    INFO(cells << " cells: " << energy / expected);
    CHECK(std::abs(energy / expected - 1) < 0.6 * error);
    error = std::abs(energy / expected - 1);
  }
  CHECK(error < 0.03);
}

// What the header says of halved squares: along the diagonal that halves them nothing is lost,
// along the other they are three times too stiff.
TEST_CASE("bending constraint: halved squares bend unlike along their diagonals", "[unit]") {
  const Sheet sheet = make_sheet(false, 64, 1.0);
  const double expected = kRigidity / 2 * sheet.area();
  const auto ratio = [&](double axis) {
    return bending_energy(sheet, rolled(sheet, 0, axis), rolled(sheet, 1, axis)) / expected;
  };
  CHECK(ratio(kPi / 2) == Approx(1).epsilon(0.03));
  CHECK(ratio(kPi / 4) == Approx(1).epsilon(0.03));
  CHECK(ratio(-kPi / 4) == Approx(3).epsilon(0.03));
}

// And of equilateral triangles: a plate whose Poisson's ratio is -1/3 stores
// D/2 ((a + b)^2 - 2 (1 + 1/3) a b) per area, for principal curvatures a and b.
TEST_CASE("bending constraint: equilateral triangles have Poisson's ratio -1/3", "[unit]") {
  const Sheet sheet = make_sheet(true, 64, 1.0);
  const double curvature = 1e-3;
  const auto ratio = [&](double a, double b) {
    std::vector<Vec3<double>> x = sheet.points;
    for (Vec3<double>& p : x) {
      p.z = curvature / 2 * (a * p.x * p.x + b * p.y * p.y);
    }
    return bending_energy(sheet, sheet.points, x) /
           (kRigidity / 2 * curvature * curvature * sheet.area());
  };
  CHECK(ratio(1, 0) == Approx(1).epsilon(0.03));
  CHECK(ratio(1, 1) == Approx(4.0 / 3).epsilon(0.03));
  CHECK(ratio(1, -1) == Approx(8.0 / 3).epsilon(0.03));
}

// A strip clamped at one end with a force at the other, solved by XPBD with rigid edges. Would
// catch a compliance or a multiplier in a wrong unit, which no energy shows.
TEST_CASE("bending constraint: a cantilever sinks by F L^3 / (3 D b)", "[property]") {
  const double h = 2e-3;  // m
  const int cells = 12;
  const double width = 2 * h;
  const double length = (cells - 0.5) * h;  // clamped in the middle of the first cell
  const double mass = 1e-6;                 // kg, of a vertex
  const double dt = 2e-3;
  const double expected = 0.02 * length;
  const double force = 3 * kRigidity * width * expected / (length * length * length);

  Sheet strip;  // three rows, squares halved to mirror each other
  for (int i = 0; i <= cells; ++i) {
    for (int j = 0; j < 3; ++j) {
      strip.points.push_back({h * i, h * j, 0});
    }
  }
  for (int i = 0; i < cells; ++i) {
    const int a = 3 * i, b = a + 3;
    strip.triangles.push_back({a, b, a + 1});
    strip.triangles.push_back({b, b + 1, a + 1});
    strip.triangles.push_back({a + 1, b + 2, a + 2});
    strip.triangles.push_back({a + 1, b + 1, b + 2});
  }
  std::vector<std::pair<int, int>> edges;
  for (const auto& t : strip.triangles) {
    for (int i = 0; i < 3; ++i) {
      const int a = t[i], b = t[(i + 1) % 3];
      edges.emplace_back(std::min(a, b), std::max(a, b));
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());

  const std::vector<Vec3<double>>& rest = strip.points;
  const std::vector<std::array<int, 4>> hinges = strip.hinges();
  std::vector<HingeAtRest> hinges_at_rest;
  for (const auto& v : hinges) {
    const Vec3<double> hinge[4] = {rest[v[0]], rest[v[1]], rest[v[2]], rest[v[3]]};
    hinges_at_rest.push_back(hinge_at_rest(hinge, kRigidity));
  }
  std::vector<Vec3<double>> x = rest, velocities(x.size());
  const auto weight = [&](int vertex) { return vertex < 6 ? 0 : 1 / mass; };
  const Substep<double> substep{1 / dt, 1 / (dt * dt)};
  for (int step = 0; step < 1500; ++step) {
    const std::vector<Vec3<double>> start = x;
    for (std::size_t i = 6; i < x.size(); ++i) {
      const bool is_tip = i + 3 >= x.size();
      velocities[i].z -= is_tip ? dt * force / 3 / mass : 0;
      x[i] = x[i] + dt * velocities[i];
    }
    std::vector<std::array<double, 1>> multipliers(edges.size() + hinges.size());
    for (int sweep = 0; sweep < 20; ++sweep) {
      for (std::size_t e = 0; e < edges.size(); ++e) {
        const auto [a, b] = edges[e];
        Vec3<double> ends[2] = {x[a], x[b]};
        const Vec3<double> along = rest[a] - rest[b];
        const double parameters[] = {std::sqrt(dot(along, along)), 0, 0};
        double multiplier[] = {multipliers[e][0]};
        DistanceConstraint::project<ProjectionMode::compliance>(ends, {weight(a), weight(b)},
                                                                parameters, substep, multiplier);
        multipliers[e][0] = multiplier[0];
        x[a] = ends[0];
        x[b] = ends[1];
      }
      for (std::size_t i = 0; i < hinges.size(); ++i) {
        const auto& v = hinges[i];
        Vec3<double> hinge[4] = {x[v[0]], x[v[1]], x[v[2]], x[v[3]]};
        const HingeAtRest& at_rest = hinges_at_rest[i];
        const double w[4] = {weight(v[0]), weight(v[1]), weight(v[2]), weight(v[3])};
        const double parameters[] = {at_rest.turn, 1 / at_rest.stiffness, 0};
        double multiplier[] = {multipliers[edges.size() + i][0]};
        BendingConstraint::project<ProjectionMode::compliance>(hinge, w, parameters, substep,
                                                               multiplier);
        multipliers[edges.size() + i][0] = multiplier[0];
        for (int corner = 0; corner < 4; ++corner) {
          x[v[corner]] = hinge[corner];
        }
      }
    }
    for (std::size_t i = 0; i < x.size(); ++i) {
      velocities[i] = (0.97 / dt) * (x[i] - start[i]);
    }
  }
  const double sunk = -(x.end()[-1].z + x.end()[-2].z + x.end()[-3].z) / 3;
  CHECK(sunk == Approx(expected).epsilon(0.01));
}

namespace {

// A hinge seen from one of its vertices: that vertex first or third.
std::array<int, 4> seen_from(int vertex) {
  return vertex % 2 == 0 ? std::array<int, 4>{0, 1, 2, 3} : std::array<int, 4>{1, 0, 3, 2};
}

VertexEnergy<double> hinge_energy(const Vec3<double> (&x)[4], int vertex, double stiffness,
                                  double rest) {
  const std::array<int, 4> order = seen_from(vertex);
  const Vec3<double> seen[4] = {x[order[0]], x[order[1]], x[order[2]], x[order[3]]};
  VertexEnergy<double> energy;
  energy.add_hinge(stiffness, rest, seen, vertex >= 2);
  return energy;
}

}  // namespace

TEST_CASE("bending in vertex blocks: the force is minus the gradient of the energy", "[property]") {
  const double edge = GENERATE(1.0, 1e-4);
  const double rest = turn_of(GENERATE(-1.0, 0.0, 2.0));
  const int vertex = GENERATE(0, 1, 2, 3);
  const double stiffness = 3e-6;
  const Hinge hinge(edge, GENERATE(-2.0, 0.1, 1.0));
  const Vec3<double> force = hinge_energy(hinge.x, vertex, stiffness, rest).force;
  const double step = 1e-5 * edge;
  for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
    Hinge low = hinge, high = hinge;
    low.x[vertex].*axis -= step;
    high.x[vertex].*axis += step;
    const double difference = std::pow(high.value(rest), 2) - std::pow(low.value(rest), 2);
    CHECK(force.*axis ==
          Approx(-stiffness / 2 * difference / (2 * step)).margin(1e-7 * stiffness / edge));
  }
}

TEST_CASE("bending in vertex blocks: at rest the Hessian is that of the energy", "[property]") {
  const double edge = 1e-3;
  const Hinge hinge(edge, GENERATE(0.0, 0.7, -2.0));
  const int vertex = GENERATE(0, 1, 2, 3);
  const double rest = hinge.value();
  const VertexEnergy<double> energy = hinge_energy(hinge.x, vertex, 1, rest);
  const double step = 1e-6 * edge;
  for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
    Hinge low = hinge, high = hinge;
    low.x[vertex].*axis -= step;
    high.x[vertex].*axis += step;
    Vec3<double> unit;
    unit.*axis = 1;
    const Vec3<double> column = (1 / (2 * step)) * (hinge_energy(low.x, vertex, 1, rest).force -
                                                    hinge_energy(high.x, vertex, 1, rest).force);
    const Vec3<double> difference = energy * unit - column;
    CHECK(std::sqrt(dot(difference, difference)) < 1e-4 / (edge * edge));
  }
}

// Would catch a step that overshoots where the gradient vanishes: folded, or far from rest.
TEST_CASE("bending in vertex blocks: no step makes the energy grow, from any shape", "[property]") {
  const double inertia = GENERATE(1e-9, 1e-3, 1.0);  // times stiffness / size^2
  const double relaxation = GENERATE(1.0, 1.9);
  double largest = 0;
  int grown = 0;
  for (std::uint64_t seed = 1; seed <= 5000; ++seed) {
    Vec3<double> x[4];
    for (int i = 0; i < 4; ++i) {
      x[i] = random_point(1, seed, i);
    }
    const double rest = 8 * random_unit(seed, 10) - 4;
    for (int vertex = 0; vertex < 4; ++vertex) {
      VertexEnergy<double> energy = hinge_energy(x, vertex, 1, rest);
      energy.add_pull(inertia, {0, 0, 0});
      const Vec3<double> move = relaxation * VertexFactor<double>(energy).solve(energy.force);
      Vec3<double> moved[4] = {x[0], x[1], x[2], x[3]};
      moved[vertex] = x[vertex] + move;
      const double before = std::pow(BendingConstraint::value(x, rest), 2);
      const double after =
          std::pow(BendingConstraint::value(moved, rest), 2) + inertia * dot(move, move);
      grown += after > before * (1 + 1e-9) ? 1 : 0;
      largest = std::max(largest, std::sqrt(dot(move, move)));
    }
  }
  CHECK(grown == 0);
  CHECK(largest < 10);
}

}  // namespace pbdsurg
