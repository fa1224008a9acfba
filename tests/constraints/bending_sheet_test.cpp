// SPDX-License-Identifier: Apache-2.0
// Many hinges: how stiff sheets of them are.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "pbdsurg/constraints/bending.h"
#include "pbdsurg/constraints/distance.h"

#include "tests/support/bending_hinge.h"
#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::kPi;

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

}  // namespace pbdsurg
